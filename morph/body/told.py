"""A pose by names, as simulations are told to start."""

from __future__ import annotations

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


def _differing(model: Any, pose: Array, place: int, names: tuple[str, ...]) -> dict[str, float]:
    # Adding 0 makes -0 a plain 0.
    return {
        name: round(float(pose[place + at]), DIGITS) + 0.0
        for at, name in enumerate(names)
        if pose[place + at] != model.qpos0[place + at]
    }
