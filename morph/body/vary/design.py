"""The parameters of a body that its card offers to a designer."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from morph.body.card import CardParameter
from morph.body.robot import Robot
from morph.body.vary.apply import vary
from morph.body.vary.lock import Lock
from morph.body.vary.operation import Operation
from morph.body.vary.operations import kind_of
from morph.body.vary.part import unknown
from morph.errors import RobotError


def with_parameters(robot: Robot, values: Mapping[str, float]) -> Robot:
    """Return a robot with parameters of its card set, in the card's order.

    Args:
        robot: The robot; its card names the parameters.
        values: For each parameter to set, by name, a value within its bounds.
            The others are left as the description has them.

    Raises:
        RobotError: The card has no such parameter, a value is out of bounds,
            or the operation that the parameter names cannot be done.
    """
    known = {parameter.name: parameter for parameter in _parameters(robot)}
    for name in values:
        if name not in known:
            raise unknown("parameter", name, known, _where(robot))
    return vary(
        robot,
        *(
            _operation(parameter, float(values[name]), robot)
            for name, parameter in known.items()
            if name in values
        ),
    )


def from_vector(robot: Robot, x: ArrayLike, names: Sequence[str] | None = None) -> Robot:
    """Return a robot with parameters of its card set to low + x (high - low).

    Args:
        robot: The robot; its card names the parameters.
        x: One number from 0 to 1 per parameter.
        names: The parameters, in the order of x; None: `tunable(robot)`.

    Raises:
        RobotError: The card has no such parameter, there are more or fewer
            numbers than parameters, or one lies outside 0 to 1.
    """
    known = {parameter.name: parameter for parameter in _parameters(robot)}
    wanted = tunable(robot) if names is None else tuple(names)
    for name in wanted:
        if name not in known:
            raise unknown("parameter", name, known, _where(robot))
    parameters = [known[name] for name in wanted]
    shares = np.atleast_1d(np.asarray(x, dtype=float))
    if shares.shape != (len(parameters),):
        raise RobotError(
            f"it has {len(parameters)} parameters, and the vector's shape is {shares.shape}",
            where=_where(robot),
            fix=f"give one number each for {', '.join(each.name for each in parameters)}",
        )
    if not ((shares >= 0) & (shares <= 1)).all():
        raise RobotError(
            f"the vector {shares.tolist()} leaves 0 to 1",
            where=_where(robot),
            fix="keep the optimiser within 0 and 1; the card's low and high are what it covers",
        )
    return with_parameters(
        robot,
        {
            each.name: min(max(each.low + share * (each.high - each.low), each.low), each.high)
            for each, share in zip(parameters, shares.tolist(), strict=True)
        },
    )


def tunable(robot: Robot) -> tuple[str, ...]:
    """Return the parameters of a robot's card that an optimiser can turn, in the card's order.

    That is all but locks: whatever its value, a lock takes a joint away.
    """
    return tuple(each.name for each in _parameters(robot) if each.operation != Lock.name)


def sweep(robot: Robot, grid: Mapping[str, Sequence[float]]) -> Iterator[Robot]:
    """Return, one at a time, a robot for each combination of parameters.

    Args:
        robot: The robot; its card names the parameters.
        grid: Values for each parameter by name; the last name changes fastest.

    Raises:
        RobotError: At once, if a parameter is unknown or a value out of bounds.
    """
    known = {parameter.name: parameter for parameter in _parameters(robot)}
    for name, values in grid.items():
        if name not in known:
            raise unknown("parameter", name, known, _where(robot))
        for value in values:
            _operation(known[name], float(value), robot)
    combinations = itertools.product(*grid.values())
    return (with_parameters(robot, dict(zip(grid, each, strict=True))) for each in combinations)


def _parameters(robot: Robot) -> tuple[CardParameter, ...]:
    return robot.card.parameter if robot.card is not None else ()


def _operation(parameter: CardParameter, value: float, robot: Robot) -> Operation:
    kind = kind_of(parameter.operation, f"{_where(robot)}, parameter {parameter.name}")
    if not kind.amount:
        raise RobotError(
            f"the operation {kind.name!r} has no amount to set",
            where=f"{_where(robot)}, parameter {parameter.name}",
            fix="name one of scale, heavier, stiffen, lock",
        )
    if not (math.isfinite(value) and parameter.low <= value <= parameter.high):
        raise RobotError(
            f"{parameter.name} is {value}, outside {parameter.low} to {parameter.high}",
            where=_where(robot),
            fix=f"choose {parameter.name} from {parameter.low} to {parameter.high}",
        )
    part = dataclasses.fields(kind)[0].name
    return kind(**{part: parameter.link, kind.amount: value})


def _where(robot: Robot) -> str:
    return f"card of {robot.name}"
