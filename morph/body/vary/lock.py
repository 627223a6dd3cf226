"""Welding two links where a joint was."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.vary.keys import keeping_keys
from morph.body.vary.operation import Operation
from morph.body.vary.part import joint
from morph.body.vary.unhook import JOINT, unhook


@dataclass(frozen=True, kw_only=True)
class Lock(Operation):
    """A joint that is no more: its link is welded to what carries it.

    A link's pose in its parent is T J1(q1) J2(q2) ..., one factor per joint.
    With J_k fixed at q, T becomes T J_k(q), and each joint before it becomes
    J_k(q)^-1 J_i J_k(q): its anchor and axis are seen from the turned link.
    Actuators, sensors, tendons and equalities on the joint go with it.
    """

    name: ClassVar[str] = "lock"
    amount: ClassVar[str] = "at"

    joint: str
    """The joint, or the link that it alone moves."""
    at: float | None = None
    """Position to hold, rad or m; None: where the joint stands in the description."""

    def __post_init__(self) -> None:
        if self.at is not None:
            self.check_finite("at")

    def apply(self, spec: Any) -> None:
        """Remove the joint and all that refers to it."""
        if not spec.joints:
            raise self.refuse("there is nothing to lock: the robot has no joints", "lock nothing")
        result = joint(spec, self.joint)
        if self.at is not None:
            self._turn(result, self.at - float(result.ref))
        with keeping_keys(spec):
            unhook(spec, JOINT, result.name)
            spec.delete(result)

    def _turn(self, result: Any, by: float) -> None:
        body = result.parent
        if result.type == mujoco.mjtJoint.mjJNT_SLIDE:
            shift, turn = result.axis / np.linalg.norm(result.axis) * by, np.eye(3)
        elif result.type == mujoco.mjtJoint.mjJNT_HINGE:
            turn = _rotation(result.axis, by)
            shift = result.pos - turn @ result.pos
        else:
            raise self.refuse("one number is no position of it", "leave out `at`, or name a hinge")
        for before in body.joints:
            if before.name == result.name:
                break
            before.pos = turn.T @ (before.pos - shift)
            before.axis = turn.T @ before.axis
        frame = matrix(body.quat)
        body.pos = body.pos + frame @ shift
        body.quat = quaternion(frame @ turn)


def matrix(turn: Array) -> Array:
    """Return the rotation matrix of a quaternion w, x, y, z; shape (3, 3)."""
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.asarray(turn, dtype=float) / np.linalg.norm(turn))
    return flat.reshape(3, 3)


def quaternion(turn: Array) -> Array:
    """Return the unit quaternion w, x, y, z of a rotation matrix."""
    result = np.zeros(4)
    mujoco.mju_mat2Quat(result, np.ascontiguousarray(turn).reshape(9))
    return result


def _rotation(axis: Array, angle: float) -> Array:
    turn = np.zeros(4)
    mujoco.mju_axisAngle2Quat(turn, axis / np.linalg.norm(axis), angle)
    return matrix(turn)
