"""What a tensor tends to as its panels become ever smaller."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array

SLOWEST, FASTEST = 1.25, 2.0
"""Bounds of a measured order: at the rim of a plate, and on a smooth surface."""

LEAST = 0.1
"""Part of what the displaced fluid itself resists, below which an entry is no longer relative."""


def extrapolated(coarse: Array, fine: Array, *, ratio: float = 2.0, order: float = 2.0) -> Array:
    """Return the limit of a quantity whose error is a power of the size of the panels.

    fine + (fine - coarse) / (ratio^order - 1) (Richardson 1911, Phil. Trans. A 210).

    Args:
        coarse: The quantity on large panels.
        fine: The quantity on small ones.
        ratio: Size of the large ones by that of the small ones.
        order: The power: 2 on smooth surfaces; 4/3 at right-angled edges, where the
            potential grows as the distance to the power of 2/3.
    """
    limit: Array = fine + (fine - coarse) / (ratio**order - 1.0)
    return limit


def limit_of_three(coarse: Array, middle: Array, fine: Array) -> Array:
    """Return the limit of each entry by the order at which that entry itself converges.

    The order is log2((middle - coarse) / (fine - middle)), kept within bounds (Roache 1998,
    "Verification and validation in computational science and engineering", sec. 5.10).

    Args:
        coarse: Entries on large panels, any shape.
        middle: On panels of half the size.
        fine: On panels of a quarter of the size.
    """
    first, second = middle - coarse, fine - middle
    # Where the steps do not shrink steadily, the slowest order is the careful one.
    steady = first * second > 0.0
    ratio = np.where(steady, first / np.where(steady, second, 1.0), 1.0)
    power = np.clip(ratio, 2.0**SLOWEST, 2.0**FASTEST)
    limit: Array = fine + second / (power - 1.0)
    return limit


def difference(one: Array, other: Array, scale: Array) -> float:
    """Return the greatest relative difference of the diagonals of two tensors.

    Args:
        one: Tensor about the centre of the volume, shape (6, 6).
        other: Another, of the same solid.
        scale: What the displaced fluid resists the six motions with were it solid, shape (6,).
            An entry below a tenth of it is compared with that tenth: the body's own
            inertia hides its error, and that of a ball that turns is 0.
    """
    size = np.maximum(np.abs(np.diag(one)), LEAST * scale)
    return float((np.abs(np.diag(one) - np.diag(other)) / size).max())
