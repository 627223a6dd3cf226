"""The actuators of a description that has none: those of its card, or one a joint."""

from __future__ import annotations

from typing import Any

import mujoco

from morph.body.card import Card, Motor
from morph.body.draft import Draft
from morph.body.servo import SERVOS, servo
from morph.errors import RobotError

DRIVEN = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
"""The joints that a motor can drive."""


def add_motors(spec: Any, card: Card | None, draft: Draft) -> None:
    """Add to a spec the motors of its card; without any, an ideal one per joint that moves.

    A joint that follows another has no motor of its own, nor has a board's slide.

    Raises:
        RobotError: A motor names a joint or a model that there is not.
    """
    following = {joint.name for joint in draft.joints if joint.mimic is not None}
    there = {joint.name for joint in draft.joints}
    joints = {joint.name: joint for joint in spec.joints if joint.type in DRIVEN}
    motors = (
        card.motor
        if card and card.motor
        else tuple(
            Motor(actuator=name) for name in joints if name in there and name not in following
        )
    )
    for motor in motors:
        _add(spec, motor, joints, draft)


def _add(spec: Any, motor: Motor, joints: dict[str, Any], draft: Draft) -> None:
    where = str(draft.file.parent / "card.toml")
    if motor.actuator not in joints:
        raise RobotError(
            f"the motor {motor.actuator!r} names no moving joint; there are {', '.join(joints)}",
            where=where,
            fix="name the motor as the joint it drives",
        )
    added = spec.add_actuator(
        name=motor.actuator, target=motor.actuator, trntype=mujoco.mjtTrn.mjTRN_JOINT
    )
    model = servo(motor.model)
    if model is not None:
        added.set_to_position(kp=model.kp, kv=model.kv)
        limit = motor.limit or model.limit
        added.forcelimited, added.forcerange = True, (-limit, limit)
        joints[motor.actuator].armature = model.armature
    elif motor.model == "ideal":
        added.set_to_motor()
        if motor.limit is not None:
            added.ctrllimited, added.ctrlrange = True, (-motor.limit, motor.limit)
    else:
        raise RobotError(
            f"no motor model is called {motor.model!r}",
            where=where,
            fix=f"use ideal or one of {', '.join(known.name for known in SERVOS)}",
        )
