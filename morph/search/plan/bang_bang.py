"""Commands that switch between their bounds, drawn by their switching times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers

MOST_SWITCHES = 5
"""Most times that a command switches before it rests."""

SHORTEST, LONGEST = 0.04, 0.65
"""Least and greatest time between two switches, in periods of the body's slowest swing."""

LEVELS = (1.0, 1.0, 0.5, 0.0)
"""Shares of the bound that an actuator beside the first may use; a body may need one alone."""


@dataclass(frozen=True, kw_only=True)
class Switches:
    """Commands of many rows: how long each stays at a bound before it goes to the other."""

    duration: Array
    """Time at each bound, s, shape (rows, nu, MOST_SWITCHES + 1); zero for those not used."""
    level: Array
    """First bound, as a share with its sign, shape (rows, nu)."""

    def commands(self, low: Array, high: Array, *, period: float, periods: int) -> Array:
        """Return the commands, shape (rows, periods, nu); one that switches within is averaged.

        A command that is held through a control period, and one that switches within it, give
        nearly the same push if their means agree; so switching times need no grid.

        Args:
            low: Bounds of the commands, shape (nu,).
            high: Likewise.
            period: Control period, s.
            periods: How many.
        """
        begins = np.cumsum(self.duration, axis=-1) - self.duration
        edges = period * np.arange(periods + 1)
        # The integral of each piece up to an edge; its sign alternates.
        sign = np.where(np.arange(self.duration.shape[-1]) % 2, -1.0, 1.0)
        spent = np.clip(edges - begins[..., None], 0.0, self.duration[..., None])
        mean = np.diff(np.einsum("s,rase->rae", sign, spent), axis=-1) / period
        share = self.level[..., None] * mean
        half, middle = 0.5 * (high - low), 0.5 * (high + low)
        return np.swapaxes(middle[:, None] + half[:, None] * share, 1, 2)

    def rows(self, which: Integers) -> Switches:
        """Return some of them."""
        return Switches(duration=self.duration[which], level=self.level[which])

    def jittered(self, spread: float, rng: np.random.Generator) -> Switches:
        """Return them with other times: each by a factor of about 1 +- spread."""
        factor = np.exp(spread * rng.standard_normal(self.duration.shape))
        return Switches(duration=self.duration * factor, level=self.level)


def drawn(rows: int, actuators: int, swing: float, rng: np.random.Generator) -> Switches:
    """Return switching times of one to `MOST_SWITCHES` switches.

    Args:
        rows: How many to draw.
        actuators: How many commands a row has.
        swing: Period of the body's slowest swing, s.
        rng: Chance.
    """
    shape = (rows, actuators, MOST_SWITCHES + 1)
    duration = swing * rng.uniform(SHORTEST, LONGEST, shape)
    pieces = rng.integers(2, MOST_SWITCHES + 2, (rows, actuators, 1))
    duration = np.where(np.arange(MOST_SWITCHES + 1) < pieces, duration, 0.0)
    level = rng.choice([-1.0, 1.0], (rows, actuators))
    if actuators > 1:
        level = level * rng.choice(LEVELS, (rows, actuators))
    return Switches(duration=duration, level=level)
