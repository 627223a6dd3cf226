"""Numbers beside a drawing, with lines to what they name that do not cross."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array

LINE = 27.0
"""Least height between two numbers, in the drawing's units."""

EDGE = 42.0
"""How far from the edge of the drawing numbers stand."""


@dataclass(frozen=True, kw_only=True)
class Callout:
    """A text beside a drawing."""

    text: str
    """What it says."""
    at: tuple[float, float]
    """The middle of the text."""
    points_to: tuple[float, float]
    """What it names."""


def callouts(
    labels: Sequence[tuple[str, Array]], *, width: float, height: float
) -> tuple[Callout, ...]:
    """Return where texts stand: in a column at either side, in the order of what they name.

    Args:
        labels: Texts, and the places in the drawing that they name, each of shape (2,).
        width: Of the drawing.
        height: Of the drawing.
    """
    order = sorted(labels, key=lambda each: float(each[1][0]))
    half = (len(order) + 1) // 2
    results = []
    for side, x in ((order[:half], EDGE), (order[half:], width - EDGE)):
        column = sorted(side, key=lambda each: float(each[1][1]))
        heights = spread(np.array([float(each[1][1]) for each in column]), height)
        results += [
            Callout(text=text, at=(x, y), points_to=(float(to[0]), float(to[1])))
            for (text, to), y in zip(column, heights.tolist(), strict=True)
        ]
    return tuple(results)


def spread(wanted: Array, height: float) -> Array:
    """Return heights in the same order, at least a line apart, as near to those wanted as can be.

    With `z_i = y_i - i d` the distance `d` becomes an order, `z_i <= z_i+1`: the nearest such
    sequence is the isotonic regression (Barlow and others 1972).

    Args:
        wanted: Rising heights, shape (texts,).
        height: Of the drawing: where all have room none is outside.
    """
    if not len(wanted):
        return wanted
    from scipy.optimize import isotonic_regression

    line = min(LINE, (height - LINE) / max(len(wanted), 1))
    steps = line * np.arange(len(wanted))
    nearest = isotonic_regression(wanted - steps).x
    low, high = 0.5 * LINE, height - 0.5 * LINE - steps[-1]
    return np.asarray(np.clip(nearest, low, max(low, high)) + steps)
