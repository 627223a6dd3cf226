"""What an axis reaches over, and the round numbers along it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from morph.app.viewer.content import ChartLine
from morph.arrays import Array

BEYOND = 1.0
"""How far an axis reaches beyond the lines that lead, by their span."""

BLOWN_UP = 1e4
"""A line that spans this many times as much as all lesser ones together has blown up."""


def values_shown(lines: Sequence[ChartLine]) -> tuple[float, float, frozenset[int]]:
    """Return the least and the greatest value of an axis, and the lines that leave it.

    Where some lines lead, the others may leave the plot. Where none does, only a line can
    that has blown up beside others.
    """
    spans = {at: span for at, line in enumerate(lines) if (span := _span(line.value))}
    if not spans:
        return 0.0, 1.0, frozenset()
    leading = [at for at in spans if lines[at].leads]
    if leading:
        low, high = _union([spans[at] for at in leading])
        room = BEYOND * ((high - low) or abs(high) or 1.0)
        every = _union(list(spans.values()))
        low, high = max(low - room, every[0]), min(high + room, every[1])
    else:
        low, high = _without_blown_up(list(spans.values()))
    slack = 1e-9 * max(abs(low), abs(high))
    out = {at for at, (a, b) in spans.items() if a < low - slack or b > high + slack}
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        # One value alone: room around it, so that the axis has a length.
        room = 0.5 * abs(high) or 0.5
        low, high = low - room, high + room
    return low, high, frozenset(out)


def rounded_steps(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Return round numbers from low to high, at most about so many, with their texts."""
    step = _step((high - low) / most)
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    values = [at * step for at in range(first, last + 1)]
    largest = max((abs(value) for value in values), default=0.0)
    short = largest >= 1e5 or (0.0 < largest < 1e-3)
    return [(value, _text(value, digits, short=short)) for value in values]


def _text(value: float, digits: int, *, short: bool) -> str:
    if value == 0.0:
        return "0"
    text = f"{value:.3g}" if short else f"{value:.{digits}f}"
    return text.replace("-", "−")


def _step(least: float) -> float:
    """Return the least of 1, 2 and 5 times a power of ten that is not below a number."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(
        each * power for each in (1.0, 2.0, 5.0, 10.0) if each * power >= least * (1 - 1e-9)
    )


def _span(value: Array) -> tuple[float, float] | None:
    finite = np.asarray(value)[np.isfinite(value)]
    return (float(finite.min()), float(finite.max())) if finite.size else None


def _union(spans: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return min(low for low, _ in spans), max(high for _, high in spans)


def _without_blown_up(spans: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the ends of all spans but those that dwarf the lesser ones together."""
    ordered = sorted(spans, key=lambda span: span[1] - span[0])
    low, high = ordered[0]
    for span in ordered[1:]:
        wider = _union([(low, high), span])
        if high > low and wider[1] - wider[0] > BLOWN_UP * (high - low):
            return low - BEYOND * (high - low), high + BEYOND * (high - low)
        low, high = wider
    return low, high
