"""The least of many small quadratics, each in a box of its own."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Mask

MOST_STEPS = 30
"""Newton steps after which the best point so far is given back."""

CLOSE = 1e-9
"""A gradient of the free numbers below this, relative to the box, ends a search."""


def boxed(H: Array, g: Array, low: Array, high: Array) -> tuple[Array, Mask]:
    """Return where 1/2 x' H x + g' x is least with low <= x <= high, and what is free there.

    Projected Newton steps: numbers that press against the box are held, the others take the
    Newton step of what is left, shortened until the quadratic falls. All rows take their steps
    at once; a row that has arrived stays.

    Source: Tassa, Mansard and Todorov 2014, Control-Limited Differential Dynamic Programming,
    ICRA, section III-A; Bertsekas 1982.

    Args:
        H: Positive definite, shape (..., n, n).
        g: Shape (..., n).
        low: Lower sides, at most `high`, shape (..., n).
        high: Upper sides.

    Returns:
        The minimiser, shape (..., n), and which of its numbers no side holds.
    """
    x = np.clip(-_solved(H, g), low, high)
    free = np.ones(x.shape, dtype=bool)
    for _ in range(MOST_STEPS):
        slope = g + _times(H, x)
        free = ~(((x <= low) & (slope > 0.0)) | ((x >= high) & (slope < 0.0)))
        step = np.where(free, -_solved(_freed(H, free), np.where(free, slope, 0.0)), 0.0)
        arrived = np.abs(np.clip(x + step, low, high) - x).max(-1, initial=0.0) <= CLOSE * (
            1.0 + np.abs(x).max(-1, initial=0.0)
        )
        if arrived.all():
            break
        x = _shortened(H, g, x, step, slope, low, high)
    return x, free


def _shortened(
    H: Array, g: Array, x: Array, step: Array, slope: Array, low: Array, high: Array
) -> Array:
    """Return the longest of ever shorter projected steps by which the quadratic falls enough."""
    before = _value(H, g, x)
    best, result = x, np.zeros(x.shape[:-1], dtype=bool)
    length = 1.0
    for _ in range(MOST_STEPS):
        tried = np.clip(x + length * step, low, high)
        promised = 0.1 * np.sum(slope * (tried - x), axis=-1)
        fell = ~result & (_value(H, g, tried) <= before + promised)
        best = np.where(fell[..., None], tried, best)
        result |= fell
        if result.all():
            break
        length *= 0.5
    return best


def freed_gain(H: Array, G: Array, free: Mask) -> Array:
    """Return -inv(H) G on the free numbers and zero on the held ones, shape (..., n, m)."""
    return np.where(free[..., None], -np.linalg.solve(_freed(H, free), G * free[..., None]), 0.0)


def _freed(H: Array, free: Mask) -> Array:
    """Return H with the rows and columns of held numbers made those of the unit matrix."""
    both = free[..., :, None] & free[..., None, :]
    return np.asarray(np.where(both, H, np.eye(H.shape[-1])), dtype=float)


def _solved(H: Array, g: Array) -> Array:
    return np.asarray(np.linalg.solve(H, g[..., None])[..., 0], dtype=float)


def _times(H: Array, x: Array) -> Array:
    return np.asarray((H @ x[..., None])[..., 0])


def _value(H: Array, g: Array, x: Array) -> Array:
    return np.asarray(np.sum(x * (g + 0.5 * _times(H, x)), axis=-1))
