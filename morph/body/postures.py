"""Postures of a robot by name: those that its description holds, on its feet, and as described."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from morph.body.limbs import HINGE, SLIDE
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.standing import standing
from morph.errors import RobotError
from morph.nearest import nearest

REST, STANDING = "rest", "standing"
"""As the description has it, and on its feet."""
USUAL = ("home", "stand", "standing", "default")
"""What keyframes of the posture in which a robot is ready are called, most usual first."""


def keyframes_of(robot: Robot, model: Any = None) -> dict[str, dict[str, float]]:
    """Return the postures of a description's keyframes, as simulations are told to start.

    Args:
        robot: The robot.
        model: Its compiled `mujoco.MjModel`, where there is one already.
    """
    model = spec_of(robot).compile() if model is None else model
    found = {}
    for at in range(model.nkey):
        told = {}
        for joint in robot.joints:
            where = model.joint(joint.name)
            place, kind = int(where.qposadr[0]), int(where.type[0])
            value = model.key_qpos[at]
            if kind in (HINGE, SLIDE):
                told[joint.name] = float(value[place])
            elif joint.kind == "free":
                names = ("position.x", "position.y", "position.z")
                turns = tuple(f"orientation.{axis}" for axis in "wxyz")
                for slot, name in enumerate((*names, *turns)):
                    told[f"{joint.link}.{name}"] = float(value[place + slot])
        found[model.key(at).name or f"keyframe {at + 1}"] = told
    return found


def posture_of(robot: Robot, name: str | None = None) -> Mapping[str, float]:
    """Return where a simulation starts, by joint, rad or m, and by channel of the base.

    Args:
        robot: The robot.
        name: That of a keyframe, `standing` or `rest`. None for the robot's own: the keyframe
            of a usual name, else on its feet, else as it is described.

    Raises:
        RobotError: It has no such posture.
    """
    if name == REST:
        return {}
    known = keyframes_of(robot)
    if name is None:
        usual = next((each for each in USUAL if each in known), None)
        if usual is not None:
            return known[usual]
    elif name in known:
        return known[name]
    if name in (None, STANDING):
        found = standing(robot)
        if found is not None:
            return found.position
        if name is None:
            return {}
    names = [*known, REST, *([STANDING] if name != STANDING else [])]
    raise RobotError(
        f"it has no posture {name!r}" + (": it has no feet" if name == STANDING else ""),
        where=f"robot {robot.name}",
        fix=f"its postures are {nearest(str(name), names)}",
    )
