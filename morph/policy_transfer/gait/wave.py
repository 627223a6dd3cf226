"""Waves: patterns of a body's limbs from four numbers that mean the same in any swimmer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action
from morph.policy_transfer.gait.limbs import Limb
from morph.search.family.family import Family, Number

NAMES = ("frequency", "amplitude", "lag", "taper")
"""What a wave is made of, in order."""


@dataclass(frozen=True, kw_only=True)
class Wave(Family):
    """Patterns in which limb after limb swings, each a little later and wider or less wide.

    A limb of place p, from 0 in front to 1 at the rear, and of sense s swings by
    s a (1 + g (2 p - 1)) sin(2 pi F t - l p): a, F, g and l are the four numbers.

    Source: Ijspeert 2008, Central pattern generators for locomotion control in animals and
    robots, Neural Networks 21(4): travelling waves as a shared frequency and phase lags.
    """

    action: tuple[Action, ...]
    """Every servo of the body."""
    limbs: tuple[Limb, ...]
    """Where each belongs."""
    period: float
    """How long each command is held, s."""

    def make(self, values: Array) -> Pattern:
        """Return the wave of a frequency, Hz, amplitude, rad, lag, rad, and taper."""
        frequency, amplitude, lag, taper = (float(each) for each in values)
        return Pattern(
            swings=tuple(
                Swing(
                    amplitude=limb.sense * amplitude * (1.0 + taper * (2.0 * limb.place - 1.0)),
                    frequency=frequency if limb.sense else 0.0,
                    phase=-lag * limb.place,
                )
                for limb in self.limbs
            ),
            action=self.action,
            period=self.period,
        )


def wave(
    action: tuple[Action, ...], limbs: tuple[Limb, ...], *, period: float, fastest: float = 3.0
) -> Wave:
    """Return the waves of a body.

    Args:
        action: What each servo takes.
        limbs: Where each belongs.
        period: How long each command is held, s.
        fastest: Greatest frequency, Hz.
    """
    reach = min(max(abs(one.low), abs(one.high)) for one in action)
    return Wave(
        numbers=(
            Number(name="frequency", low=0.1, high=fastest, start=0.5 * fastest),
            Number(name="amplitude", low=0.0, high=reach, start=0.4 * reach),
            Number(name="lag", low=-math.pi, high=4.0 * math.pi, start=1.5 * math.pi),
            Number(name="taper", low=-1.0, high=1.0, start=0.0),
        ),
        action=action,
        limbs=limbs,
        period=period,
    )


def at(family: Family, values: Array) -> Array:
    """Return the point of the cube that makes these values, or the nearest on its faces."""
    low, high = (np.array([getattr(n, end) for n in family.numbers]) for end in ("low", "high"))
    return np.asarray(np.clip((values - low) / (high - low), 0.0, 1.0))
