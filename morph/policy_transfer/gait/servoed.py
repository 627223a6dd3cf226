"""A body whose motors have become servos: what runs a loop about each joint, in memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco

from morph.body.robot import Robot
from morph.body.vary.apply import vary
from morph.body.vary.operation import Operation

LIMIT = 1e3
"""Effort of a motor of which no limit is known, N m."""


@dataclass(frozen=True, kw_only=True)
class AddServo(Operation):
    """A motor on a joint that has become a servo: k (command - q) - d v."""

    name: ClassVar[str] = "servo"
    amount: ClassVar[str] = "stiffness"

    actuator: str
    """The motor."""
    stiffness: float
    """k, N m/rad."""
    damping: float
    """d, N m s/rad."""
    reach: float
    """Farthest that it is told either way, rad."""

    def __post_init__(self) -> None:
        self.check_finite("stiffness", "damping", "reach")

    def apply(self, spec: Any) -> None:
        """Make the motor a servo."""
        result = spec.actuator(self.actuator)
        if result is None:
            raise self.refuse(f"there is no actuator {self.actuator!r}", "name a motor of the body")
        limit = max(abs(float(end)) for end in result.ctrlrange) or LIMIT
        result.set_to_position(kp=self.stiffness, kv=self.damping)
        result.gear = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        result.forcerange, result.forcelimited = (-limit, limit), mujoco.mjtLimited.mjLIMITED_TRUE
        result.ctrlrange = (-self.reach, self.reach)
        result.ctrllimited = mujoco.mjtLimited.mjLIMITED_TRUE


def servoed(
    robot: Robot, *, yields: float = 0.3, settles: float = 0.1, reach: float = 1.2
) -> Robot:
    """Return a body with a servo for each of its motors; one of servos comes back as it is.

    Args:
        robot: The body; it is not changed.
        yields: How far off a servo must be to push as hard as its motor can, rad.
        settles: Its damping over its stiffness, s.
        reach: Farthest that it is told either way, rad.
    """
    motors = [each for each in robot.actuators if each.kind != "position"]
    return vary(
        robot,
        *(
            AddServo(
                actuator=each.name,
                stiffness=(each.limit or LIMIT) / yields,
                damping=settles * (each.limit or LIMIT) / yields,
                reach=reach,
            )
            for each in motors
        ),
    )
