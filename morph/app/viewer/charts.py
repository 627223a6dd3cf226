"""Charts as SVG: drawn once, with a cursor that a style alone moves along."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from morph.app.viewer.axis import rounded_steps, values_shown
from morph.app.viewer.content import Chart, ChartLine
from morph.arrays import Array

WIDTH, HEIGHT = 400.0, 150.0
"""Of a chart, in its own units: about the pixels that the panel has."""

LEFT, RIGHT, TOP, BOTTOM = 48.0, 12.0, 8.0, 20.0
"""Room around the lines, for the numbers at the axes."""

MOST_POINTS = 600
"""Points of one line: more than the panel has columns."""

DASHES = ("", "7 4", "2 3", "8 3 2 3", "12 3", "1 4", "5 2 1 2 1 2", "14 4 4 4")
"""Patterns of lines in order, so that nobody needs colours to tell them apart."""

MARGIN = 0.05
"""Room above and below the values, by their span."""


def chart_html(chart: Chart, seconds: float) -> str:
    """Return a chart over a clock of so many seconds, as HTML.

    Its cursor stands where the style's number `--morph-now`, 0 to 1, says.
    """
    low, high, left_out = values_shown(chart.lines)
    frame = _Frame(seconds=max(seconds, 1e-9), low=low, high=high)
    dashes = [_dashes(at, line) for at, line in enumerate(chart.lines)]
    title = escape(f"{chart.title} ({chart.unit})" if chart.unit else chart.title)
    lines = "".join(
        f'<path d="{frame.path(line)}" stroke="{escape(line.colour)}"{_dashed(dash)}/>'
        for line, dash in zip(chart.lines, dashes, strict=True)
    )
    named = "".join(
        f'<li><svg class="key" viewBox="0 0 26 8" aria-hidden="true"><path d="M1 4H25" '
        f'stroke="{escape(line.colour)}"{_dashed(dash)}/></svg>{escape(line.name)}'
        f"{' (leaves the plot)' if at in left_out else ''}</li>"
        for at, (line, dash) in enumerate(zip(chart.lines, dashes, strict=True))
    )
    wide, tall = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    return (
        f'<figure class="morph"><figcaption>{title}</figcaption>'
        f'<svg class="chart" role="img" aria-label="{title}" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" '
        f'data-left="{LEFT / WIDTH:g}" data-wide="{wide / WIDTH:g}">{frame.axes()}'
        # An SVG within cuts off what leaves the plot, and needs no name for it.
        f'<svg x="{LEFT:g}" y="{TOP:g}" width="{wide:g}" height="{tall:g}">{lines}'
        f'<path class="now" d="M0 0V{tall:g}" '
        f'style="transform:translateX(calc(var(--morph-now,0)*{wide:g}px))"/></svg></svg>'
        f'<ul class="legend">{named}</ul></figure>'
    )


def now_html(time: float, seconds: float) -> str:
    """Return the style that puts every chart's cursor where the clock is, s."""
    share = min(max(time / seconds, 0.0), 1.0) if seconds > 0.0 else 0.0
    return f"<style>:root{{--morph-now:{share:.4f}}}</style>"


def thinned(time: Array, value: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """Return at most about so many points of a line, of which no peak is lost.

    Of each stretch of time the least and the greatest value stay, in their order, and where
    it has a gap, one point of that.
    """
    if len(time) <= most:
        return time, value
    keep = []
    for part in np.array_split(np.arange(len(time)), max(most // 2, 1)):
        there = np.isfinite(time[part]) & np.isfinite(value[part])
        if not there.all():
            keep.append(int(part[~there][0]))
        good = part[there]
        if len(good):
            keep += [int(good[value[good].argmin()]), int(good[value[good].argmax()])]
    places = np.unique([0, *keep, len(time) - 1])
    return time[places], value[places]


class _Frame:
    """Where times and values are in the picture."""

    def __init__(self, *, seconds: float, low: float, high: float) -> None:
        self.seconds = seconds
        room = MARGIN * (high - low)
        self.low, self.high = low - room, high + room
        self.wide, self.tall = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def across(self, time: Array) -> Array:
        """Return how far right times are, in the plot."""
        return time / self.seconds * self.wide

    def down(self, value: Array) -> Array:
        """Return how far down values are, in the plot; what is far off stays just beyond it."""
        share = (self.high - value) / (self.high - self.low)
        return np.clip(share, -1.0, 2.0) * self.tall

    def path(self, line: ChartLine) -> str:
        """Return a line as the commands of a path."""
        time, value = thinned(np.asarray(line.time), np.asarray(line.value))
        drawn, down = [], False
        for x, y in zip(self.across(time).tolist(), self.down(value).tolist(), strict=True):
            if not (math.isfinite(x) and math.isfinite(y)):
                down = False
                continue
            drawn.append(f"{'L' if down else 'M'}{x:.1f} {y:.1f}")
            down = True
        return "".join(drawn)

    def axes(self) -> str:
        """Return both axes with their numbers."""
        parts = []
        for value, text in rounded_steps(self.low, self.high, 5):
            y = TOP + float(self.down(np.array(value)))
            parts.append(
                f'<path class="rule" d="M{LEFT:g} {y:.1f}H{WIDTH - RIGHT:g}"/>'
                f'<text x="{LEFT - 5:g}" y="{y + 3.5:.1f}" text-anchor="end">{text}</text>'
            )
        steps = rounded_steps(0.0, self.seconds, 6)
        for at, (value, text) in enumerate(steps):
            x = LEFT + float(self.across(np.array(value)))
            last = at == len(steps) - 1
            parts.append(
                f'<path class="tick" d="M{x:.1f} {HEIGHT - BOTTOM:g}v3"/>'
                f'<text x="{x:.1f}" y="{HEIGHT - 5:g}" text-anchor="middle">{text}'
                f"{' s' if last else ''}</text>"
            )
        parts.append(f'<path class="tick" d="M{LEFT:g} {HEIGHT - BOTTOM:g}H{WIDTH - RIGHT:g}"/>')
        return "".join(parts)


def _dashes(at: int, line: ChartLine) -> str:
    """Return the pattern of a line by its place; none but a line that is not dashed is solid."""
    pattern = DASHES[at % len(DASHES)]
    return pattern or (DASHES[1] if line.dashed else "")


def _dashed(dash: str) -> str:
    return f' stroke-dasharray="{dash}"' if dash else ""


def colours(count: int) -> Sequence[str]:
    """Return so many colours that are told apart, also by most of the colour blind.

    Source: Okabe and Ito 2008, Color Universal Design; black and yellow are left out, which
    are lost on a dark or on a light page.
    """
    chosen = (
        "#0072b2",
        "#d55e00",
        "#009e73",
        "#cc79a7",
        "#56b4e9",
        "#e69f00",
        "#8c6bb1",
        "#7a7a7a",
    )
    return tuple(chosen[at % len(chosen)] for at in range(count))
