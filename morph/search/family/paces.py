"""Gaits of a body with servos about a posture, such as bent knees: a stride that servos hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from morph.arrays import Array
from morph.body.robot import Robot
from morph.policy.pattern import Pattern
from morph.policy.policy import Action, actions_of
from morph.search.family.family import Family
from morph.search.family.gait import Gait, gait, room_about

WIDEST = 0.3
"""Farthest that a set point swings from the posture, rad."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Paces(Family):
    """Patterns p + g(t): the set points of a gait g about a posture p.

    A gait alone swings as far as the nearer limit of a joint lets it, so that a body described
    on straight legs never lifts a foot: about bent knees it has room both ways.
    """

    gait: Gait
    """What swings, about the posture; its numbers are this family's."""
    action: tuple[Action, ...]
    """Every actuator of the body."""
    posture: Array
    """p, rad or m, shape (actuators,)."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of these values, in the order of `numbers`."""
        swung = self.gait.make(values)
        swings = tuple(
            replace(swing, offset=swing.offset + float(place))
            for swing, place in zip(swung.swings, self.posture, strict=True)
        )
        return Pattern(swings=swings, action=self.action, period=self.gait.period)


def paces(
    robot: Robot, posture: Mapping[str, float], *, roles: tuple[str, ...] | None, period: float
) -> Paces:
    """Return the gaits of a robot about a posture.

    Args:
        robot: The body.
        posture: Where joints are between their swings, by name, rad; others are at zero.
        roles: Names of the roles that swing, such as `knee_y`; None for all.
        period: How long each command is held, s.

    Raises:
        SearchError: It has no actuator, or none of such a role.
    """
    place, room = room_about(robot, posture, WIDEST)
    swung = gait(robot, period=period, roles=roles, action=room)
    return Paces(numbers=swung.numbers, gait=swung, action=actions_of(robot), posture=place)
