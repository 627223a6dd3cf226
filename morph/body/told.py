"""A pose by names, as simulations are told to start."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot

DIGITS = 5
"""Decimals, which read better and start as well."""
PLACES = ("x", "y", "z")
TURNS = ("w", "x", "y", "z")


def told(robot: Robot, model: Any, pose: Array) -> dict[str, float]:
    """Return what of a pose differs from the description, by joint and by channel of the base.

    Args:
        robot: The robot.
        model: Its compiled `mujoco.MjModel`.
        pose: `qpos`, shape (nq,).

    Returns:
        Hinges, rad, and slides, m, by name; of what floats `hull.position.z`, m, and all of
        `hull.orientation`, a quaternion; of a ball joint all of `ball.orientation`.
    """
    result: dict[str, float] = {}
    for joint in robot.joints:
        place = int(model.joint(joint.name).qposadr[0])
        if joint.kind in {"hinge", "slide"}:
            result |= _differing(model, pose, place, (joint.name,))
            continue
        part = joint.link if joint.kind == "free" else joint.name
        if joint.kind == "free":
            names = tuple(f"{part}.position.{axis}" for axis in PLACES)
            result |= _differing(model, pose, place, names)
            place += len(PLACES)
        turned = range(place, place + len(TURNS))
        if not np.array_equal(pose[turned], model.qpos0[turned]):
            pairs = zip(TURNS, pose[turned].tolist(), strict=True)
            result |= {f"{part}.orientation.{axis}": value for axis, value in pairs}
    return result


def posed(robot: Robot, model: Any, posture: Mapping[str, float]) -> Array:
    """Return the pose that `told` tells of, `qpos`, shape (nq,).

    Args:
        robot: The robot.
        model: Its compiled `mujoco.MjModel`.
        posture: Values by joint and by channel of the base; others than its own are passed over.
    """
    pose: Array = model.qpos0.copy()
    for joint in robot.joints:
        place = int(model.joint(joint.name).qposadr[0])
        if joint.kind in {"hinge", "slide"}:
            pose[place] = posture.get(joint.name, pose[place])
            continue
        part = joint.link if joint.kind == "free" else joint.name
        if joint.kind == "free":
            for axis in PLACES:
                pose[place] = posture.get(f"{part}.position.{axis}", pose[place])
                place += 1
        turned = np.array([posture.get(f"{part}.orientation.{axis}", 0.0) for axis in TURNS])
        if turned.any():
            pose[place : place + len(TURNS)] = turned / np.linalg.norm(turned)
    return pose


def posture_names(robot: Robot) -> set[str]:
    """Return what a posture of a robot may name."""
    result: set[str] = set()
    for joint in robot.joints:
        if joint.kind in {"hinge", "slide"}:
            result.add(joint.name)
            continue
        part = joint.link if joint.kind == "free" else joint.name
        places = PLACES if joint.kind == "free" else ()
        result |= {f"{part}.position.{axis}" for axis in places}
        result |= {f"{part}.orientation.{axis}" for axis in TURNS}
    return result


def _differing(model: Any, pose: Array, place: int, names: tuple[str, ...]) -> dict[str, float]:
    # Adding 0 makes -0 a plain 0.
    return {
        name: round(float(pose[place + at]), DIGITS) + 0.0
        for at, name in enumerate(names)
        if pose[place + at] != model.qpos0[place + at]
    }
