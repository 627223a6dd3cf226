"""Numbers about their middle, in their spreads, so that metres and radians can be compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError

LEAST_SPREAD = 1e-9
"""Less spread than this is none: a number that never changes is left as it is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Standardizer:
    """z = (x - middle) / spread."""

    middle: Array
    """Shape (n,)."""
    spread: Array
    """Above 0, shape (n,)."""

    def __call__(self, x: Array) -> Array:
        """Return scaled numbers, shape (..., n)."""
        return np.asarray((x - self.middle) / self.spread)

    def back(self, z: Array) -> Array:
        """Return the numbers that are scaled to these, shape (..., n)."""
        return np.asarray(self.middle + self.spread * z)


def scale(x: Array) -> Standardizer:
    """Return what gives every column of these data a mean of 0 and a standard deviation of 1.

    Args:
        x: Shape (m, n), at least two rows.

    Raises:
        SamplesError: There are fewer.
    """
    if x.ndim != 2 or len(x) < 2:
        raise SamplesError(
            f"data have the shape {x.shape}",
            where="a scale",
            fix="give at least two rows of numbers",
        )
    spread = x.std(axis=0)
    return Standardizer(middle=x.mean(axis=0), spread=np.where(spread > LEAST_SPREAD, spread, 1.0))
