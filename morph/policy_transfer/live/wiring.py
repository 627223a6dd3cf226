"""A target's channels and actuators as the body's own: matched by name, refused by unit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import TransferError
from morph.nearest import nearest
from morph.policy.observing import addresses, units
from morph.policy.policy import actions_of
from morph.policy_transfer.live.protocol import Hello, Signal, number
from morph.record.units import UNITS

SAME_PERIOD = 1e-6
"""How far a target's period may be from the task's, as a share of it."""


def hello_for(robot: Robot, period: float) -> Hello:
    """Return what a target of this body would say that keeps no time of its own."""
    return Hello(
        channels=tuple(Signal(name=name, unit=unit) for name, unit in units(robot).items()),
        actuators=tuple(Signal(name=x.actuator, unit=x.unit) for x in actions_of(robot)),
        period=period,
        clock="none",
    )


class Wiring:
    """Which number of a target is which of the body's.

    Args:
        robot: The body.
        model: Its compiled `mujoco.MjModel`.
        hello: What the target says of itself.
        period: The task's control period, s.
        where: How messages call the target.

    Raises:
        TransferError: A channel or an actuator of the body is missing or in another unit, the
            target has an actuator that the body lacks, or its period is another.
    """

    def __init__(
        self, robot: Robot, model: Any, hello: Hello, *, period: float, where: str
    ) -> None:
        wanted = hello_for(robot, period)
        _match(wanted.channels, hello.channels, "channel", robot, where)
        _match(wanted.actuators, hello.actuators, "actuator", robot, where)
        unknown = {x.name for x in hello.actuators} - {x.name for x in wanted.actuators}
        if unknown:
            raise TransferError(
                f"it has the actuator {', '.join(sorted(unknown))}, which {robot.name} lacks: "
                "nobody would command it",
                where=where,
                fix="describe it in the body, or let the target hold it by itself and not name it",
            )
        if abs(hello.period - period) > SAME_PERIOD * period:
            raise TransferError(
                f"its states come every {hello.period:g} s, and the task counts every {period:g} s",
                where=where,
                fix=f"let it send states every {period:g} s, or give the task its period",
            )
        self._at = addresses(robot, model)
        self._nq, self._size = model.nq, model.nq + model.nv
        self.actuators = tuple(x.name for x in wanted.actuators)
        self.unused = tuple(x.name for x in hello.channels if x.name not in self._at)

    def state(self, message: Mapping[str, Any]) -> tuple[Array, Array]:
        """Return `qpos` (nq,) and `qvel` (nv,); nan where the target says no finite number."""
        state = np.full(self._size, math.nan)
        for name, at in self._at.items():
            state[at] = number(message.get(name))
        return state[: self._nq], state[self._nq :]

    def missing(self, position: Array, velocity: Array) -> list[str]:
        """Return the channels that are no number in a state."""
        state = np.concatenate([position, velocity])
        return [name for name, at in self._at.items() if not math.isfinite(state[at])]

    def told(self, command: Array) -> dict[str, float]:
        """Return commands by actuator, out of shape (nu,)."""
        return {name: float(u) for name, u in zip(self.actuators, command, strict=True)}


def _match(
    wanted: Sequence[Signal], results: Sequence[Signal], what: str, robot: Robot, where: str
) -> None:
    """Refuse a target that lacks a signal of the body, or has it in another unit."""
    given = {each.name: each.unit for each in results}
    for each in wanted:
        if each.name not in given:
            raise TransferError(
                f"it has no {what} {each.name!r} ({each.unit}), which {robot.name} has; "
                f"its nearest are {nearest(each.name, given)}",
                where=where,
                fix=f"let it name its {what}s as `morph inspect {robot.name}` names them",
            )
        if given[each.name] != each.unit:
            raise TransferError(
                f"its {what} {each.name!r} is in {given[each.name]}, and {robot.name} has it in "
                f"{each.unit}",
                where=where,
                fix=_conversion(given[each.name], each.unit),
            )


def _conversion(given: str, wanted: str) -> str:
    """Return how a number in one unit becomes one in the other, if there is a way."""
    one, other = UNITS.get(given), UNITS.get(wanted)
    if one is None or other is None or one.dimension != other.dimension:
        return f"let it give {wanted}; {given} measures something else, or is not known"
    factor = one.factor / other.factor
    named = " (pi / 180)" if math.isclose(factor, math.pi / 180.0) else ""
    return f"let it give {wanted}: 1 {given} is {factor:.9g}{named} {wanted}"
