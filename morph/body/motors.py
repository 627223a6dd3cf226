"""The actuators of a description that has none, and servos in the place of any."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco

from morph.body.card import Card, Motor
from morph.body.draft import Draft
from morph.body.normal import robot_of
from morph.body.robot import Robot
from morph.body.servo import SERVOS, servo
from morph.body.spec import bare_spec
from morph.errors import RobotError
from morph.files import sha256

DRIVEN = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
"""The joints that a motor can drive."""
SERVO = "servo"
"""Model of a servo that has no name."""
FIGURES = ("kp", "kv", "limit", "armature", "friction")
"""What is said of a motor in numbers."""


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
    _drive(added, joints[motor.actuator], motor, where)


def _drive(actuator: Any, joint: Any, motor: Motor, where: str) -> None:
    """Make an actuator of a spec what drives its joint as a motor says."""
    model = servo(motor.model)
    if model is None and motor.model not in ("ideal", SERVO):
        raise RobotError(
            f"no motor model is called {motor.model!r}",
            where=where,
            fix=f"use ideal, {SERVO} or one of {', '.join(known.name for known in SERVOS)}",
        )
    figures = {
        name: getattr(model, name, None) if value is None else value
        for name in FIGURES
        for value in (getattr(motor, name),)
    }
    for name, value in figures.items():
        if value is not None and not (math.isfinite(value) and value >= 0.0):
            raise RobotError(
                f"{name} of the motor of {joint.name} is {value:g}",
                where=where,
                fix=f"give {name} as a number that is not negative",
            )
    if figures["limit"] == 0.0:
        raise RobotError(
            f"the limit of the motor of {joint.name} is 0",
            where=where,
            fix="give the greatest effort, N m or N, or leave it out",
        )
    kp, kv, limit = (figures[name] for name in ("kp", "kv", "limit"))
    if motor.model == "ideal":
        if kp is not None or kv is not None:
            raise RobotError(
                f"the motor of {joint.name} is ideal and has gains",
                where=where,
                fix=f'say model = "{SERVO}", or leave kp and kv out',
            )
        actuator.set_to_motor()
        if limit is not None:
            actuator.ctrllimited, actuator.ctrlrange = True, (-limit, limit)
    else:
        if not kp:
            raise RobotError(
                f"the servo of {joint.name} has no kp",
                where=where,
                fix="give kp, N m/rad or N/m, and kv",
            )
        actuator.set_to_position(kp=kp, kv=kv or 0.0)
        if limit is not None:
            actuator.forcelimited, actuator.forcerange = True, (-limit, limit)
    if figures["armature"] is not None:
        joint.armature = figures["armature"]
    if figures["friction"] is not None:
        joint.frictionloss = figures["friction"]


def with_servos(robot: Robot, words: Sequence[str]) -> Robot:
    """Return a robot of which the actuators of hinges and slides are servos.

    Args:
        robot: The robot.
        words: Each `[JOINT:][NAME][,FIGURE=VALUE ...]`: a servo's name, or its figures `kp`, `kv`,
            `limit`, `armature` and `friction`, or both. Without a joint it is at every one; what
            stands later goes before.

    Raises:
        RobotError: Words are none of that, or nothing drives a joint that they name.
    """
    driven = {each.joint: each.name for each in robot.actuators if each.joint}
    count = Counter(each.joint for each in robot.actuators)
    chosen: dict[str, Motor] = {}
    for each in words:
        joint, _, what = each.rpartition(":")
        if joint and joint not in driven:
            raise RobotError(
                f"nothing drives a joint {joint!r}",
                where=f"servo {each}",
                fix=f"name one of {', '.join(driven)}",
            )
        motor = _motor(what, each)
        chosen |= dict.fromkeys([joint] if joint else driven, motor)
    spec = bare_spec(robot)
    joints = {joint.name: joint for joint in spec.joints}
    actuators = {actuator.name: actuator for actuator in spec.actuators}
    for name, motor in chosen.items():
        if count[name] > 1:
            raise RobotError(
                f"{count[name]} actuators drive the joint {name}",
                where=f"servo of {name}",
                fix="leave one of them in the description, or give servos to other joints",
            )
        actuator = actuators[driven[name]]
        # Gears and bounds of what was there are not those of the servo.
        actuator.gear = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        actuator.ctrllimited = actuator.forcelimited = False
        _drive(actuator, joints[name], motor, f"servo of {name}")
    served = robot_of(spec, robot.source or Path(robot.name), robot.card, dict(robot.assets))
    known = {joint.name: joint for joint in served.joints}
    return replace(
        robot,
        mjcf=served.mjcf,
        actuators=served.actuators,
        joints=tuple(
            replace(known[each.name], velocity=each.velocity, mimic=each.mimic)
            for each in robot.joints
        ),
        sha256=sha256(robot.sha256, "servos", *words),
    )


def _motor(what: str, words: str) -> Motor:
    parts = [part.strip() for part in what.split(",")]
    pairs = [part.partition("=") for part in parts if "=" in part]
    names = [part for part in parts if "=" not in part]
    try:
        figures = {key.strip(): float(value) for key, _, value in pairs}
    except ValueError:
        figures = {"": 0.0}
    if len(names) > 1 or set(figures) - set(FIGURES) or len(figures) < len(pairs):
        raise RobotError(
            "it says no servo",
            where=f"servo {words}",
            fix=f"write NAME or {SERVO} figures such as kp=20,kv=1,limit=6; figures are "
            f"{', '.join(FIGURES)}, names {', '.join(known.name for known in SERVOS)}",
        )
    return Motor(actuator="", model=names[0] if names else SERVO, **figures)
