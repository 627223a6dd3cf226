"""Interquartile means, and how sure they are: the figures of every study of transfer.

Source: Agarwal, Schwarzer, Castro, Courville and Bellemare 2021, NeurIPS, section 4.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from morph.arrays import Array

DRAWS = 2000
"""Bootstrap samples of an interval."""

LEVEL = 0.95
"""How often an interval should hold the truth."""


def iqm(x: Array) -> float:
    """Return the mean of the middle half of all numbers, whatever the shape.

    The numbers at its two ends count by the share of them that lies within the middle half, so
    that it changes smoothly with how many there are. Infinite numbers may lie in the outer
    quarters: times that were never reached.
    """
    return float(_iqms(np.asarray(x, dtype=float).reshape(1, -1))[0])


def _iqms(rows: Array) -> Array:
    """Return the interquartile mean of each of many rows, shape (rows,)."""
    count = rows.shape[1]
    edges = np.arange(count + 1)
    low, high = 0.25 * count, 0.75 * count
    share = np.clip(np.minimum(edges[1:], high) - np.maximum(edges[:-1], low), 0.0, 1.0)
    held = share > 0.0
    middle = np.ascontiguousarray(np.sort(rows, axis=1)[:, held])
    return np.asarray((share[held] * middle).sum(axis=1) / share.sum())


def interval(
    scores: Array, *, of: Callable[[Array], float] = iqm, level: float = LEVEL, seed: int = 0
) -> tuple[float, float]:
    """Return the stratified bootstrap interval of a figure over strata and seeds.

    Each draw takes, within every stratum by itself, as many of its seeds with putting back.

    Args:
        scores: Shape (strata, seeds), or (seeds,) for one stratum.
        of: The figure.
        level: How often the interval should hold the truth, 0 to 1.
        seed: Of the draws.
    """
    table = np.atleast_2d(np.asarray(scores, dtype=float))
    rng = np.random.default_rng(seed)
    strata, seeds = table.shape
    draws = rng.integers(seeds, size=(DRAWS, strata, seeds))
    if of is iqm:
        # Thousands of calls of `iqm` would take as long as a small study.
        found = _iqms(table[np.arange(strata)[:, None], draws].reshape(DRAWS, -1))
    else:
        found = np.array([of(np.take_along_axis(table, draw, axis=1)) for draw in draws])
    tail = 0.5 * (1.0 - level)
    # Not interpolated: a draw may be infinite, and infinity less infinity is no number.
    low, high = np.quantile(found, (tail, 1.0 - tail), method="nearest")
    return float(low), float(high)


def mean_interval(x: Array, *, middle: bool = False) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of a mean, or of an interquartile mean, over seeds.

    It equals `interval` of one stratum with all draws taken at once, for studies with thousands
    of intervals: both statistics are weighted sums of the sorted values.

    Args:
        x: Values, shape (seeds,).
        middle: Whether the statistic is the interquartile mean.
    """
    n = len(x)
    # The weights of the last 1, 2, ... sorted numbers together; their differences are the weights.
    steps = [iqm((np.arange(n) >= k).astype(float)) for k in range(n)]
    weight = -np.diff([*steps, 0.0]) if middle else np.full(n, 1.0 / n)
    draws = np.random.default_rng(0).integers(n, size=(DRAWS, n))
    found = np.sort(x[draws], axis=1) @ weight
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.quantile(found, (tail, 1.0 - tail), method="nearest")
    return float(low), float(high)
