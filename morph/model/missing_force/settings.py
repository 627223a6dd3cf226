"""Settings of the missing force, and how the evidence chooses them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array

FACTORS = (3.0, 1.6)
"""Factors by which each setting is tried larger and smaller, one sweep of all after another."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceSettings:
    """How large and how rough the missing force may be, and what stays unexplained."""

    own: Array
    """Standard deviation of the rough part, as a share of the forces of the motion, (joints,)."""
    whole: Array
    """Of the smooth part, likewise."""
    own_length: float
    """Velocity over which the rough part changes, as a share of its size."""
    length: float
    """Distance over which the smooth part changes, in sizes."""
    jump: Array
    """Unexplained jump of a velocity in a period, in deviations of its noise, (joints,)."""

    @property
    def logs(self) -> Array:
        """The logarithms of all, shape (3 joints + 2,)."""
        lengths = np.array([self.own_length, self.length])
        return np.asarray(np.log(np.concatenate([self.own, self.whole, self.jump, lengths])))

    def moved(self, logs: Array) -> ForceSettings:
        """Return settings with other logarithms."""
        joints, values = len(self.own), np.exp(logs)
        return replace(
            self,
            own=values[:joints],
            whole=values[joints : 2 * joints],
            jump=values[2 * joints : -2],
            own_length=float(values[-2]),
            length=float(values[-1]),
        )

    @property
    def prior(self) -> tuple[Array, Array]:
        """Middle and standard deviation of each logarithm, shape (3 joints + 2,) both."""
        joints = len(self.own)
        listed = [(0.05, 1.5)] * (2 * joints) + [(0.2, 1.0)] * joints + [(1.0, 0.7), (2.0, 0.5)]
        middle, spread = np.array(listed).T
        return np.log(middle), spread


def first_settings(joints: int) -> ForceSettings:
    """Return the settings that are likeliest before any data."""
    blank = ForceSettings(
        own=np.ones(joints), whole=np.ones(joints), own_length=1.0, length=1.0, jump=np.ones(joints)
    )
    return blank.moved(blank.prior[0])


def settled(
    before: ForceSettings, evidence: Callable[[ForceSettings], float], free: tuple[int, ...]
) -> ForceSettings:
    """Return settings of higher evidence and prior, each tried in turn.

    Args:
        before: Where to begin.
        evidence: log p(runs | settings).
        free: Which of the logarithms may move.
    """
    middle, spread = before.prior

    def score(logs: Array) -> float:
        off = (logs - middle) / spread
        return evidence(before.moved(logs)) - 0.5 * float(off @ off)

    best = before.logs
    highest = score(best)
    for factor in FACTORS:
        for at in free:
            for sign in (1.0, -1.0):
                tried, gained = best.copy(), False
                # Further in the same direction as long as it helps.
                for _ in range(3):
                    tried = tried.copy()
                    tried[at] += sign * np.log(factor)
                    value = score(tried)
                    if value <= highest:
                        break
                    best, highest, gained = tried, value, True
                if gained:
                    break
    return before.moved(best)
