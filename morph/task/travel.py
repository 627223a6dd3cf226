"""What going somewhere costs, and when a body has gone far enough."""

from __future__ import annotations

from collections.abc import Mapping

from morph.body.robot import Robot
from morph.task.quantity import Commands, Point
from morph.task.term import Goal, Term
from morph.task.torso import origin_of

AIM = 1.5
"""Distance that the cost asks for, in distances of the goal: so that noise costs no success."""

STRAY = 0.5
"""Farthest aside that a body may come, in distances of the goal."""


def travel_terms(
    robot: Robot, link: str, start: Mapping[str, float], distance: float
) -> tuple[Term, ...]:
    """Return the costs of not having come `distance` along x at the end, and of straying aside."""
    x, y, _ = origin_of(robot, link, start)
    return (
        Term(
            name="forward",
            quantity=Point(link=link, axes="x"),
            target=(float(x) + AIM * distance,),
            width=0.5 * distance,
            last_only=True,
        ),
        Term(
            name="aside",
            quantity=Point(link=link, axes="y"),
            target=(float(y),),
            width=0.5 * distance,
            last_only=True,
        ),
        *effort_terms(robot, weight=1e-4),
    )


def travel_goals(
    robot: Robot, link: str, start: Mapping[str, float], distance: float
) -> tuple[Goal, ...]:
    """Return the goals: at least so far along x at the end, and not half as far aside."""
    x, y, _ = origin_of(robot, link, start)
    forward, aside = Point(link=link, axes="x"), Point(link=link, axes="y")
    return (
        Goal(name="forward", quantity=forward, target=(float(x) + distance,), beyond=True),
        Goal(name="straight", quantity=aside, target=(float(y),), within=STRAY * distance),
    )


def effort_terms(robot: Robot, *, weight: float) -> tuple[Term, ...]:
    """Return a small cost of effort for each motor; a servo's command is a place, and free."""
    return tuple(
        Term(
            name=f"effort of {actuator.name}",
            quantity=Commands(actuators=(actuator.name,)),
            target=(0.0,),
            width=actuator.limit,
            weight=weight,
        )
        for actuator in robot.actuators
        if actuator.kind == "motor" and actuator.limit
    )
