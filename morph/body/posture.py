"""Poses of a body: which joints are free to be set, and where all others follow."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Integers
from morph.body.follow import followers

CLOSED = 1e-6
"""How far from closed a loop may stay, m or rad."""

STRIDE = 0.2
"""Farthest that joints go before loops are closed again, rad or m: from near, the way that the
loop was assembled is the one that is found."""

SHORTEST = 1e-3
"""Where loops do not close, the way there is halved down to this, rad or m."""

JUMP = 5.0
"""What follows may go this many times as far as `STRIDE`; beyond, it was assembled another way."""

TURNS = 25
"""Most steps of Newton's method."""

LIKE = 1e-6
"""A joint adds nothing to those chosen before if less than this is left of its column."""

FREE, BALL = mujoco.mjtJoint.mjJNT_FREE.value, mujoco.mjtJoint.mjJNT_BALL.value
HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value


@dataclass(frozen=True, kw_only=True)
class Handle:
    """A joint that is free to be set."""

    joint: str
    """Its name."""
    link: str
    """The link that it moves."""
    kind: str
    """`hinge` or `slide`."""
    low: float
    """Least position, rad or m; of a hinge without limits half a turn back."""
    high: float
    """Greatest position."""
    rest: float
    """Where the description has it."""
    limited: bool
    """Whether the description limits it."""

    @property
    def ranged(self) -> bool:
        """Whether its range means something: that of a slide without limits is made up."""
        return self.limited or self.kind == "hinge"


class Posture:
    """Poses of a model in which every loop is closed and every follower follows.

    Hinges and slides are free unless a constraint ties them: of those that are tied, what is
    driven stays free and what nothing drives follows.

    Args:
        model: The `mujoco.MjModel`; it is not changed.
    """

    def __init__(self, model: Any) -> None:
        """Find out which joints are free."""
        self.model = copy.copy(model)
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self.data = mujoco.MjData(self.model)
        self.rest: Array = self.model.qpos0.copy()
        self.tied = self._tied()
        """The degrees of freedom that follow, shape (tied,)."""
        closed = self._closed(self.rest) if len(self.tied) else self.rest
        self.sound = closed is not None
        """Whether its loops close as it is described; if not, nothing follows."""
        if closed is None:
            self.tied = np.zeros(0, dtype=np.int64)
        else:
            self.rest = closed
        follows = set(self.tied.tolist())
        free = [
            joint
            for joint in range(model.njnt)
            if model.jnt_type[joint] in (HINGE, SLIDE) and model.jnt_dofadr[joint] not in follows
        ]
        self.handles = tuple(self._handle(joint) for joint in free)
        self.places: Integers = model.jnt_qposadr[free].astype(np.int64)
        """Where each handle stands in `qpos`."""
        self.dofs: Integers = model.jnt_dofadr[free].astype(np.int64)
        """Which degree of freedom each handle is."""

    def towards(self, start: Array, goal: Array) -> tuple[Array, bool]:
        """Return the pose that a way from one pose to others ends in, and whether it arrived.

        Args:
            start: A pose that is closed, `qpos`.
            goal: Where each handle is to go, rad or m, shape (handles,); what lies beyond a
                handle's range is brought back into it.

        Returns:
            `qpos` and True; or the last pose on the way in which the loops close and what
            follows stays within its limits, and False.
        """
        low = np.array([handle.low for handle in self.handles])
        high = np.array([handle.high for handle in self.handles])
        goal = np.clip(np.where(np.isfinite(goal), goal, start[self.places]), low, high)
        way = goal - start[self.places]
        pose = np.array(start)
        if not len(self.tied):
            pose[self.places] = goal
            return pose, True
        far = max(float(np.abs(way).max(initial=0.0)), 1e-12)
        gone, stride = 0.0, STRIDE / far
        while gone < 1.0:
            reached = min(1.0, gone + stride)
            tried = pose.copy()
            tried[self.places] = start[self.places] + way * reached
            closed = self._closed(tried)
            if closed is not None and self._within(closed, pose):
                pose, gone, stride = closed, reached, min(2.0 * stride, STRIDE / far)
            elif stride * far < SHORTEST:
                return pose, False
            else:
                stride /= 2.0
        return pose, True

    def slopes(self) -> Array:
        """Return how all move with the handles at the pose in `data`, shape (dofs, handles).

        J v = 0 holds for every movement v that keeps the loops closed, so that what follows
        moves by v_tied = -J_tied^+ J_free v_free.
        """
        result = np.zeros((self.model.nv, len(self.dofs)))
        result[self.dofs, np.arange(len(self.dofs))] = 1.0
        if len(self.tied):
            mujoco.mj_makeConstraint(self.model, self.data)
            _, J = self._constraint()
            result[self.tied] = -np.linalg.lstsq(J[:, self.tied], J[:, self.dofs], rcond=1e-9)[0]
        return result

    def _closed(self, pose: Array) -> Array | None:
        """Return a pose with its loops closed by what follows; None if they do not close."""
        pose, step = pose.copy(), np.zeros(self.model.nv)
        for _ in range(TURNS):
            self.data.qpos[:] = pose
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            mujoco.mj_tendon(self.model, self.data)
            mujoco.mj_makeConstraint(self.model, self.data)
            gap, J = self._constraint()
            if np.abs(gap).max(initial=0.0) < 1e-3 * CLOSED:
                return pose
            moved = np.linalg.lstsq(J[:, self.tied], -gap, rcond=1e-9)[0]
            step[self.tied] = moved * min(1.0, 0.5 / max(float(np.abs(moved).max()), 1e-12))
            mujoco.mj_integratePos(self.model, pose, step, 1.0)
        return pose if np.abs(gap).max() < CLOSED else None

    def _constraint(self) -> tuple[Array, Array]:
        """Return how far open what ties joints is, and its Jacobian: (rows,) and (rows, dofs)."""
        rows = int(self.data.ne)
        J = np.array(self.data.efc_J).reshape(-1, self.model.nv)[:rows]
        return np.array(self.data.efc_pos[:rows]), J

    def _tied(self) -> Integers:
        self.data.qpos[:] = self.model.qpos0
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_tendon(self.model, self.data)
        mujoco.mj_makeConstraint(self.model, self.data)
        if not self.data.ne:
            return np.zeros(0, dtype=np.int64)
        _, J = self._constraint()
        chosen: list[int] = []
        basis = np.zeros((len(J), 0))
        for dof in self._willing():
            column = J[:, dof]
            left = column - basis @ (basis.T @ column)
            size = float(np.linalg.norm(left))
            if size > LIKE * max(1.0, float(np.linalg.norm(column))):
                chosen.append(dof)
                basis = np.column_stack((basis, left / size))
        return np.array(sorted(chosen), dtype=np.int64)

    def _willing(self) -> list[int]:
        """Return degrees of freedom, those first that may best follow.

        First what mimics, then what nothing drives, those far out before those near the base;
        what floats never does.
        """
        model = self.model
        mimics, _ = followers(model)
        driven = {
            int(model.actuator_trnid[at, 0])
            for at in range(model.nu)
            if model.actuator_trntype[at] == mujoco.mjtTrn.mjTRN_JOINT
        }
        ranked = sorted(
            (joint not in mimics, joint in driven, -int(model.jnt_dofadr[joint]), joint)
            for joint in range(model.njnt)
            if model.jnt_type[joint] != FREE
        )
        wide = {BALL: 3}
        return [
            int(model.jnt_dofadr[joint]) + offset
            for *_, joint in ranked
            for offset in range(wide.get(int(model.jnt_type[joint]), 1))
        ]

    def _within(self, pose: Array, before: Array) -> bool:
        """Return whether what follows came from near, and is within its limits or nears them."""
        model = self.model
        at = model.jnt_qposadr[model.dof_jntid[self.tied]]
        if np.abs(pose[at] - before[at]).max() > JUMP * STRIDE:
            return False
        for dof in self.tied.tolist():
            joint = int(model.dof_jntid[dof])
            if model.jnt_limited[joint] and model.jnt_type[joint] in (HINGE, SLIDE):
                at = int(model.jnt_qposadr[joint])
                low, high = model.jnt_range[joint]
                beyond = max(low - pose[at], pose[at] - high)
                if beyond > CLOSED and beyond > max(low - before[at], before[at] - high):
                    return False
        return True

    def _handle(self, joint: int) -> Handle:
        model = self.model
        kind = "hinge" if model.jnt_type[joint] == HINGE else "slide"
        rest = float(self.rest[model.jnt_qposadr[joint]])
        limited = bool(model.jnt_limited[joint])
        # A slide without limits has no natural range: as far as the body is large.
        most = math.pi if kind == "hinge" else max(2.0 * float(model.stat.extent), 0.1)
        low, high = model.jnt_range[joint].tolist() if limited else (rest - most, rest + most)
        return Handle(
            joint=model.joint(joint).name,
            link=model.body(model.jnt_bodyid[joint]).name,
            kind=kind,
            low=min(low, rest),
            high=max(high, rest),
            rest=rest,
            limited=limited,
        )
