"""What a designer may change of a body: its card's parameters, or general ones of a link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from morph.body.card import SCHEMA, Card, CardParameter
from morph.body.robot import Robot
from morph.body.vary import Lock, Stiffen, with_parameters
from morph.errors import RobotError

WHOLE = "*"
"""What stands for all links."""

FACTORS = (0.5, 2.0)
"""Range of the general parameters: half to double."""

UNITS = {"scale": "x size", "heavier": "x mass", "stiffen": "N m/rad", "lock": "rad"}
"""What an operation's amount is told in."""


def general(robot: Robot) -> tuple[CardParameter, ...]:
    """Return parameters that every body has: size and mass of the whole and of each link."""
    weighed = [link.name for link in robot.links if link.mass > 0.0]
    return tuple(
        CardParameter(
            name=f"{'whole body' if link == WHOLE else link}: {what}",
            operation=operation,
            link=link,
            low=FACTORS[0],
            high=FACTORS[1],
        )
        for link in (WHOLE, *weighed)
        for what, operation in (("size", "scale"), ("mass", "heavier"))
    )


def neutral(parameter: CardParameter) -> float:
    """Return the amount nearest to where a parameter changes nothing; of a lock, to zero."""
    return min(max(_plain(parameter), parameter.low), parameter.high)


def _plain(parameter: CardParameter) -> float:
    return 0.0 if parameter.operation in (Stiffen.name, Lock.name) else 1.0


def changes(parameter: CardParameter, value: float) -> bool:
    """Return whether a value of a parameter changes anything."""
    return parameter.operation == Lock.name or value != _plain(parameter)


def designed(
    robot: Robot, parameters: Sequence[CardParameter], values: Mapping[str, float]
) -> Robot:
    """Return a robot with parameters set; its card stays its own.

    Args:
        robot: The robot as described.
        parameters: Those that it may be changed by, of its card or not.
        values: By a parameter's name its value.

    Raises:
        RobotError: A value is out of bounds, or an operation cannot be done.
    """
    values = effective(parameters, values)
    if not values:
        return robot
    card = robot.card or _stand_in(robot)
    requested = replace(robot, card=replace(card, parameter=tuple(parameters)))
    result = with_parameters(requested, values)
    if robot.card is None or result.card is None:
        return replace(result, card=None)
    parts = {link.name for link in result.links} | {joint.name for joint in result.joints}
    kept = tuple(each for each in robot.card.parameter if each.link in {WHOLE, *parts})
    return replace(result, card=replace(result.card, parameter=kept))


def effective(parameters: Sequence[CardParameter], values: Mapping[str, float]) -> dict[str, float]:
    """Return values without those that act on a joint which another of them takes away."""
    by = {parameter.name: parameter for parameter in parameters}
    locked = {by[name].link for name in values if name in by and by[name].operation == Lock.name}
    return {
        name: value
        for name, value in values.items()
        if not (name in by and by[name].operation == Stiffen.name and by[name].link in locked)
    }


def usable(robot: Robot, parameters: Sequence[CardParameter]) -> tuple[CardParameter, ...]:
    """Return the parameters that can be set on a robot: their joint or link is there."""
    kept = []
    for parameter in parameters:
        try:
            designed(robot, parameters, {parameter.name: neutral(parameter)})
        except RobotError:
            continue
        kept.append(parameter)
    return tuple(kept)


def _stand_in(robot: Robot) -> Card:
    return Card(
        schema=SCHEMA,
        name=robot.name,
        title=robot.name,
        description="",
        base="fixed",
        source=(),
        licence="",
    )
