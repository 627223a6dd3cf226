"""What an environment shows of a body and takes from outside: channels and scaled commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.arrays import Array, Integers
from morph.body.robot import Joint, Robot
from morph.errors import TaskError
from morph.nearest import nearest
from morph.sim.start import PLACES, SPEEDS

MOST = 1e6
"""Greatest reading, in its unit: libraries ask for finite bounds, and what is above is clipped."""

FREE_HINGE = math.pi
"""What an action of 1 asks of a servo whose hinge has no limits, rad."""

FREE = 1.0
"""What an action of 1 asks where nothing else bounds it: m of a servo, N m or N of a motor."""


def channels(robot: Robot) -> tuple[str, ...]:
    """Return every channel that follows from the state: positions first, then velocities.

    Joints in the body's order, named as recordings name them; a ball joint has none.
    """
    return tuple(name for rate in (0, 1) for joint in robot.joints for name in _names(joint, rate))


def _names(joint: Joint, rate: int) -> Sequence[str]:
    if joint.kind == "free":
        return [f"{joint.link}.{name}" for name in (PLACES, SPEEDS)[rate]]
    single = joint.kind in {"hinge", "slide"}
    return [f"{joint.name}.{('position', 'velocity')[rate]}"] if single else []


def columns(robot: Robot, model: Any, named: Sequence[str]) -> Integers:
    """Return where channels stand in MuJoCo's (qpos, qvel), one after the other.

    Raises:
        TaskError: The state has no such channel.
    """
    where: dict[str, int] = {}
    for joint in robot.joints:
        here = model.joint(joint.name)
        for rate, first in enumerate((here.qposadr[0], model.nq + here.dofadr[0])):
            where |= {name: int(first) + at for at, name in enumerate(_names(joint, rate))}
    for name in named:
        if name not in where:
            raise TaskError(
                f"it observes {name!r}, which the state does not hold",
                where=f"an environment of {robot.name}",
                fix=f"the nearest channels are {nearest(name, tuple(where))}",
            )
    return np.array([where[name] for name in named], dtype=np.int64)


def command_range(robot: Robot) -> tuple[Array, Array]:
    """Return the commands that actions of -1 and 1 stand for, shape (actuators,) each.

    A motor's is its effort either way, a servo's the range of its joint; what has no limit
    gets `FREE` or `FREE_HINGE` either way.
    """
    low, high = [], []
    for actuator in robot.actuators:
        free, bounds = FREE, None
        if actuator.kind == "position":
            joint = robot.driven_by(actuator)
            free = FREE_HINGE if joint.kind == "hinge" else FREE
            bounds = joint.limits
        elif actuator.limit is not None:
            bounds = (-actuator.limit, actuator.limit)
        bounds = bounds or (-free, free)
        low.append(bounds[0] if math.isfinite(bounds[0]) else -free)
        high.append(bounds[1] if math.isfinite(bounds[1]) else free)
    return np.array(low), np.array(high)
