"""Arms: where the end is, in which posture it is at a point, and what holds it there."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.task.chain import end_of

DRAWN = 200
"""Postures that are drawn to find a point that an arm can reach."""

DAMPING = 1e-4
"""Square of the damping of inverse kinematics, m2."""


class Arm:
    """Where the end of an arm is, and in which posture it is at a point.

    The end is the last site of the description, such as a gripper's tip; without a site, the
    end of the last link as if it were a uniform rod.
    """

    def __init__(self, robot: Robot) -> None:
        """Compile, and find the end and the driven joints."""
        self._model: Any = spec_of(robot).compile()
        self._data = mujoco.MjData(self._model)
        if self._model.nsite:
            site = self._model.nsite - 1
            self.link = str(self._model.body(self._model.site_bodyid[site]).name)
            x, y, z = (float(each) for each in self._model.site_pos[site])
            self.offset = (x, y, z)
        else:
            self.link, self.offset = end_of(robot)
        self.joints = robot.driven
        limits = [robot.joint(name).limits or (-math.pi, math.pi) for name in self.joints]
        self.low, self.high = np.array(limits, dtype=float).reshape(-1, 2).T
        self._at = [int(self._model.joint(name).qposadr[0]) for name in self.joints]
        self._dofs = [int(self._model.joint(name).dofadr[0]) for name in self.joints]

    def rest(self) -> dict[str, float]:
        """Return the position of each driven joint as the body is described, rad or m."""
        return dict(zip(self.joints, self._model.qpos0[self._at].tolist(), strict=True))

    def far(self) -> Array:
        """Return a point that the end can reach, far from where it rests, m, shape (3,).

        Of some postures in the middle of the ranges, the one whose end is farthest; none whose
        end is lower than a tenth of the way from the arm's root to where the end rests.
        """
        rng = np.random.default_rng(0)
        rest = self.end(np.clip(self._model.qpos0[self._at], self.low, self.high))
        middle, half = (self.low + self.high) / 2.0, (self.high - self.low) / 2.0
        drawn = middle + 0.6 * half * rng.uniform(-1.0, 1.0, size=(DRAWN, len(middle)))
        ends = np.array([self.end(each) for each in drawn])
        root = self._data.xanchor[self._model.joint(self.joints[0]).id]
        low = ends[:, 2] < root[2] + 0.1 * (rest[2] - root[2])
        return np.asarray(ends[np.argmax(np.linalg.norm(ends - rest, axis=1) - 1e3 * low)])

    def end(self, posture: Array) -> Array:
        """Return where the end is, m, shape (3,)."""
        self._place(posture)
        body = self._model.body(self.link).id
        rotation = self._data.xmat[body].reshape(3, 3)
        return np.asarray(self._data.xpos[body] + rotation @ np.array(self.offset))

    def posture(self, point: Array, *, tries: int = 8) -> tuple[Array, float]:
        """Return the posture that brings the end nearest to a point, and how far off it stays, m.

        Damped least squares, dq = J^T (J J^T + l^2 I)^-1 e, within the joints' limits, from
        rest and from some postures between the limits.

        Source: Wampler 1986, Manipulator inverse kinematic solutions based on vector
        formulations and damped least-squares methods, IEEE Trans. Systems, Man, Cybernetics.
        """
        rng = np.random.default_rng(0)
        rest = np.clip(self._model.qpos0[self._at], self.low, self.high)
        starts = [rest, *rng.uniform(self.low, self.high, size=(tries, len(rest)))]
        return min((self._descend(point, start) for start in starts), key=lambda each: each[1])

    def along(self, points: Array) -> Array:
        """Return postures that follow points, each found from the last, shape (points, joints)."""
        posture, _ = self.posture(points[0])
        result = np.empty((len(points), len(posture)))
        for at, point in enumerate(points):
            posture, _ = self._descend(point, posture)
            result[at] = posture
        return result

    def _descend(self, point: Array, posture: Array) -> tuple[Array, float]:
        jacobian = np.zeros((3, self._model.nv))
        error = point - self.end(posture)
        for _ in range(100):
            if np.linalg.norm(error) < 1e-6:
                break
            body = self._model.body(self.link).id
            mujoco.mj_jac(self._model, self._data, jacobian, None, point - error, body)
            J = jacobian[:, self._dofs]
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(3), error)
            posture = np.clip(posture + step, self.low, self.high)
            error = point - self.end(posture)
        return posture, float(np.linalg.norm(error))

    def holding(self, posture: Array) -> Array:
        """Return the efforts that gravity asks of the joints, N m or N, shape (joints,)."""
        self._place(posture)
        mujoco.mj_comVel(self._model, self._data)
        self._data.qvel[:] = 0.0
        self._data.qacc[:] = 0.0
        mujoco.mj_inverse(self._model, self._data)
        return np.asarray(self._data.qfrc_inverse[self._dofs])

    def _place(self, posture: Array) -> None:
        self._data.qpos[:] = self._model.qpos0
        self._data.qpos[self._at] = posture
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
