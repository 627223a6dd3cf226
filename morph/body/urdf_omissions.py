"""What a robot has and URDF cannot hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.body.robot import Robot

NAMED = 5
"""Names that are told before the rest is counted."""


def omissions(robot: Robot, model: Any) -> list[str]:
    """Return, in words, what the URDF of a compiled robot leaves out."""
    return [
        *_joints(robot, model),
        *(f"the closed chain {loop.name or ' and '.join(loop.links)}" for loop in robot.loops),
        *_forces(model),
        *_counted(robot, model),
    ]


def few(names: Sequence[str]) -> str:
    """Return names in words, the first few of them."""
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _joints(robot: Robot, model: Any) -> list[str]:
    left = []
    servos = [actuator.name for actuator in robot.actuators if actuator.kind == "position"]
    if servos:
        left.append(f"the gains of {_many(len(servos), 'servo')}")
    driven = set(robot.driven)
    passive = [
        joint.name
        for joint in robot.joints
        if joint.kind in ("hinge", "slide") and joint.name not in driven and joint.mimic is None
    ]
    if passive and driven:
        left.append(f"that nothing drives {few(passive)}")
    if others := [actuator.name for actuator in robot.actuators if actuator.joint is None]:
        left.append(f"the actuators without a joint, {few(others)}")
    if np.any(model.dof_armature):
        left.append("the rotors' inertia (armature)")
    if np.any(model.jnt_stiffness):
        left.append("the joints' springs")
    return left


def _forces(model: Any) -> list[str]:
    left = []
    masks = {
        (int(a), int(b)) for a, b in zip(model.geom_contype, model.geom_conaffinity, strict=True)
    }
    if model.nexclude or model.npair or masks - {(0, 0), (1, 1)}:
        left.append("which of its parts may touch each other")
    option = model.opt
    if option.density or option.viscosity or np.any(option.wind):
        left.append("the fluid around it")
    if np.any(model.body_gravcomp):
        left.append("what carries its weight (gravcomp)")
    if not np.allclose(option.gravity, (0, 0, -9.81)):
        left.append("its own gravity")
    return left


def _counted(robot: Robot, model: Any) -> list[str]:
    return [
        _many(number, name)
        for number, name in (
            (len(robot.sensors), "sensor"),
            (model.ntendon, "tendon"),
            (model.nkey, "keyframe"),
        )
        if number
    ]


def _many(number: int, name: str) -> str:
    return f"{number} {name}" + ("" if number == 1 else "s")
