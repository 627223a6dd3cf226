"""Patterns servo by servo: what may be learned where nobody knows which servo belongs where."""

from __future__ import annotations

import math
from dataclasses import dataclass

from morph.arrays import Array
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action
from morph.search.family.family import Family, Number


@dataclass(frozen=True, kw_only=True)
class Free(Family):
    """Patterns in which every servo has an amplitude and a phase of its own, at one frequency.

    With n servos 1 + 2 n numbers. An amplitude may be below zero.
    """

    action: tuple[Action, ...]
    """Every servo of the body."""
    period: float
    """How long each command is held, s."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of a frequency, Hz, all amplitudes, rad, and then all phases, rad."""
        size = len(self.action)
        return Pattern(
            swings=tuple(
                Swing(
                    frequency=float(values[0]),
                    amplitude=float(values[1 + at]),
                    phase=float(values[1 + size + at]),
                )
                for at in range(size)
            ),
            action=self.action,
            period=self.period,
        )


def free(action: tuple[Action, ...], *, period: float, fastest: float = 3.0) -> Free:
    """Return the patterns of a body of servos, one by one."""
    reach = [min(abs(one.low), abs(one.high)) for one in action]
    turn = math.pi
    return Free(
        numbers=(
            Number(name="frequency", low=0.1, high=fastest, start=0.5 * fastest),
            *(
                Number(name=f"{one.actuator} amplitude", low=-most, high=most, start=0.4 * most)
                for one, most in zip(action, reach, strict=True)
            ),
            *(
                Number(name=f"{one.actuator} phase", low=-turn, high=turn, start=0.0)
                for one in action
            ),
        ),
        action=action,
        period=period,
    )
