"""Paces: patterns of a body's legs from seven numbers that mean the same on any legs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from morph.arrays import Array
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action
from morph.policy_transfer.gait.limbs import Limb
from morph.search.family.family import Family, Number


@dataclass(frozen=True, kw_only=True)
class Pace(Family):
    """Patterns in which every leg swings and lifts alike, those of other corners later.

    With r half the range of a servo and m its middle, a leg of side d and place p is told, with
    t = 2 pi F time - b d - l p, the swing m + s a r sin(t) and the lift
    m + s (c + h sin(t + f)) r: F, a, h, f, b, l and c are the seven numbers.

    Source: Ijspeert 2008, Central pattern generators for locomotion control in animals and
    robots, Neural Networks 21(4): gaits as a shared frequency and phase lags.
    """

    action: tuple[Action, ...]
    """Every servo of the body."""
    limbs: tuple[Limb, ...]
    """Which swings and which lifts."""
    period: float
    """How long each command is held, s."""

    def make(self, values: Array) -> Pattern:
        """Return the pace of a frequency, swing, lift, phase, lags of right and rear, crouch."""
        frequency, swing, lift, phase, right, rear, crouch = (float(each) for each in values)
        swings = []
        for limb, one in zip(self.limbs, self.action, strict=True):
            middle, half = 0.5 * (one.low + one.high), 0.5 * (one.high - one.low)
            late = right * limb.side + rear * limb.place
            lifts = limb.role == "lift"
            swings.append(
                Swing(
                    offset=middle + (limb.sense * crouch * half if lifts else 0.0),
                    amplitude=limb.sense * half * (lift if lifts else swing),
                    frequency=frequency if limb.sense else 0.0,
                    phase=(phase if lifts else 0.0) - late,
                )
            )
        return Pattern(swings=tuple(swings), action=self.action, period=self.period)


def pace(
    action: tuple[Action, ...], limbs: tuple[Limb, ...], *, period: float, fastest: float = 5.0
) -> Pace:
    """Return the paces of a body on legs."""
    turn = 2.0 * math.pi
    return Pace(
        numbers=(
            Number(name="frequency", low=0.2, high=fastest, start=0.4 * fastest),
            Number(name="swing", low=0.0, high=1.0, start=0.4),
            Number(name="lift", low=0.0, high=1.0, start=0.4),
            Number(name="phase", low=-0.25 * turn, high=1.25 * turn, start=0.25 * turn),
            Number(name="lag of the right", low=-0.25 * turn, high=1.25 * turn, start=0.5 * turn),
            Number(name="lag of the rear", low=-0.25 * turn, high=1.25 * turn, start=0.5 * turn),
            Number(name="crouch", low=-0.6, high=0.6, start=0.0),
        ),
        action=action,
        limbs=limbs,
        period=period,
    )
