"""What each motor must hold when a body stands still in a pose."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.posture import Posture
from morph.body.robot import Robot


@dataclass(frozen=True, kw_only=True)
class HoldingMotor:
    """A motor and what it is for."""

    name: str
    """The actuator's name."""
    joint: str
    """The joint that it drives."""
    unit: str
    """Of its effort: `N m` or `N`."""
    limit: float | None
    """Greatest effort at the joint; None if none is known."""


class Holding:
    """Static efforts of a body's motors.

    A body in a pose q at rest has the generalized force g(q) of gravity and of springs to be
    held. Movements that keep its loops closed are v = S v_free (`Posture.slopes`), so its motors,
    at the joints A, must give efforts u with (A S)^T u = S^T g: the principle of virtual work.
    Joints without a motor are held by nothing and count as locked; so does what floats: its
    base is held.

    Args:
        robot: The body.
        posture: The poses that it can take.
    """

    def __init__(self, robot: Robot, posture: Posture) -> None:
        """Find the joints of the motors."""
        self._posture, model = posture, posture.model
        known = [(each, robot.driven_by(each)) for each in robot.actuators if each.joint]
        self.motors = tuple(
            HoldingMotor(
                name=each.name,
                joint=joint.name,
                unit=joint.effort_unit,
                limit=each.limit if each.limit is not None else joint.effort,
            )
            for each, joint in known
        )
        self._dofs = [int(model.joint(joint.name).dofadr[0]) for _, joint in known]
        # Motors on one joint share its load.
        self._shared = np.array([self._dofs.count(dof) for dof in self._dofs], dtype=float)
        self.limits: Array = np.array(
            [np.nan if motor.limit is None else motor.limit for motor in self.motors], dtype=float
        )
        """The motors' limits, N m or N, NaN where none is known, shape (motors,)."""

    def at(self, pose: Array) -> Array:
        """Return each motor's effort in a pose, N m or N, shape (motors,)."""
        model, data = self._posture.model, self._posture.data
        data.qpos[:] = pose
        data.qvel[:] = 0.0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_passive(model, data)
        force = np.zeros(model.nv)
        mujoco.mj_rne(model, data, 0, force)
        force -= data.qfrc_passive
        if not self._dofs:
            return np.zeros(0)
        if not len(self._posture.tied):
            return np.asarray(force[self._dofs] / self._shared)
        S = self._posture.slopes()
        return np.asarray(np.linalg.lstsq(S[self._dofs].T, S.T @ force, rcond=1e-9)[0])


def margins(efforts: Array, limits: Array) -> Array:
    """Return the share of each motor's limit that is left, 1 - |u| / limit; NaN without a limit.

    Below 0 it cannot hold. Efforts have shape (..., motors).
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(1.0 - np.abs(efforts) / limits)


def least(efforts: Array, limits: Array) -> tuple[float | None, int | None]:
    """Return the least margin and whose it is; None where no motor has a limit."""
    left = margins(efforts, limits)
    if not np.isfinite(left).any():
        return None, None
    worst = int(np.nanargmin(left))
    return float(left[worst]), worst
