"""Boxes in rows on the ground, with room between them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from morph.arrays import Array

GAP = 0.35
"""Room between two boxes, by the size of the smaller; at least a third of it by the larger."""

CLEAR = 0.6
"""Room before a row, by the height of the boxes in it, so that they hide little behind them."""


def gap(first: float, second: float) -> float:
    """Return the room between two boxes of so large bodies, m."""
    return GAP * max(min(first, second), max(first, second) / 3.0)


def in_file(low: Array, high: Array, size: Array, widths: Array, spread: float = 1.0) -> Array:
    """Return where boxes stand one beside the other along y, m, shape (boxes, 2).

    Args:
        low: Their least corners, shape (boxes, 3).
        high: Their greatest corners.
        size: How large their bodies are, m, shape (boxes,).
        widths: Room that each takes along y at the least, m, shape (boxes,).
        spread: How many times the room between them is taken.
    """
    turned = _along(low[:, 1], high[:, 1], size, widths, spread)
    return np.stack((-0.5 * (low[:, 0] + high[:, 0]), turned), axis=1)


def in_rows(low: Array, high: Array, size: Array, widths: Array, rows: int) -> Array:
    """Return where boxes stand in so many rows along x, the first at the back.

    Args:
        low: Their least corners, shape (boxes, 3).
        high: Their greatest corners.
        size: How large their bodies are, m, shape (boxes,).
        widths: Room that each takes along x at the least, m, shape (boxes,).
        rows: How many rows, 1 or more.

    Returns:
        Where each box's origin is to be, m, shape (boxes, 2).
    """
    places = np.zeros((len(low), 2))
    columns = math.ceil(len(low) / rows)
    front = 0.0
    for first in range(0, len(low), columns):
        row = slice(first, first + columns)
        places[row, 0] = _along(low[row, 0], high[row, 0], size[row], widths[row])
        if first:
            height = float((high[row, 2] - low[row, 2]).max())
            before = float(size[first - columns : first].max())
            front -= max(gap(before, float(size[row].max())), CLEAR * height)
        # The boxes of a row are in line by their middles.
        deep = high[row, 1] - low[row, 1]
        middle = 0.5 * (high[row, 1] + low[row, 1])
        places[row, 1] = front - 0.5 * float(deep.max()) - middle
        front -= float(deep.max())
    return places


def _along(low: Array, high: Array, size: Array, widths: Array, spread: float = 1.0) -> Array:
    """Return where spans begin so that they follow each other about 0, shape (spans,)."""
    taken = np.maximum(high - low, widths)
    between = [spread * gap(float(a), float(b)) for a, b in pairwise(size)]
    start = np.concatenate(([0.0], np.cumsum(taken[:-1] + np.array(between))))
    whole = float(start[-1] + taken[-1])
    return np.asarray(start + 0.5 * taken - 0.5 * (low + high) - 0.5 * whole)
