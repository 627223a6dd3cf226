"""Small plots as SVG: they need no script, can be printed, and follow the page's colours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from morph.arrays import Array

WIDTH, HEIGHT = 320.0, 190.0
"""Size of a plot, in its own units; the page scales it."""

LEFT, RIGHT, TOP, BOTTOM = 46.0, 8.0, 8.0, 34.0
"""Room for figures around what is drawn."""

MOST_POINTS = 400
"""Points drawn of one line: more than the plot has columns."""

DECADES = 1.5
"""Values that span more powers of ten, all above zero, are drawn by their logarithm."""


@dataclass(frozen=True, kw_only=True)
class PlottedLine:
    """One curve."""

    x: Array
    """Where, shape (points,)."""
    y: Array
    """How much, shape (points,); a gap where it is no number."""
    look: str = "main"
    """Its class on the page: `main`, `faint`, or `held` for a rule across."""
    dots: bool = False
    """Whether every point is marked."""


@dataclass(frozen=True, kw_only=True)
class GoalBand:
    """A box that is to be reached."""

    x: tuple[float, float]
    """From where to where."""
    y: tuple[float, float]
    """From how much to how much."""


@dataclass(frozen=True, kw_only=True)
class Plot:
    """Curves on common axes."""

    title: str
    """What is drawn."""
    x_title: str
    """What runs to the right."""
    lines: tuple[PlottedLine, ...]
    """The curves, the last on top."""
    bands: tuple[GoalBand, ...] = ()
    """What is to be reached."""
    bounds: tuple[float, ...] = ()
    """Levels that are not to be passed, drawn as dashes where they are near."""
    rules: tuple[tuple[float, str], ...] = ()
    """Levels to compare with, each with its name."""
    from_zero: bool = False
    """Whether what runs to the right begins at 0."""
    counted: bool = False
    """Whether what runs to the right is counted: no fractions are marked."""

    @property
    def svg(self) -> Markup:
        """The plot as an element of a page."""
        axes = _Axes(self)
        parts = [*axes.drawn()]
        for band in self.bands:
            (a, b), (c, d) = axes.x(np.array(band.x)), axes.y(np.array(band.y))
            parts.append(
                f'<rect class="band" x="{a:.1f}" y="{d:.1f}" '
                f'width="{max(b - a, 3.0):.1f}" height="{max(c - d, 1.0):.1f}"/>'
            )
        for level in self.bounds:
            parts += axes.across(level, "bound")
        taken: list[float] = []
        for level, name in self.rules:
            parts += axes.across(level, "held")
            parts += axes.named(level, name, taken)
        for line in self.lines:
            parts += axes.curve(line)
        spoken = escape(f"{self.title}, over {self.x_title}")
        return Markup(
            f'<svg class="plot" viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" '
            f'aria-label="{spoken}">{"".join(parts)}</svg>'
        )


class _Axes:
    """From what is drawn to where it stands."""

    def __init__(self, plot: Plot) -> None:
        xs, ys = _all([line.x for line in plot.lines]), _all([line.y for line in plot.lines])
        xs = np.append(xs, 0.0) if plot.from_zero else xs
        ys = np.concatenate([ys, [level for level, _ in plot.rules if math.isfinite(level)]])
        ys = np.concatenate([ys, *[band.y for band in plot.bands]])
        self.log = bool(len(ys) and ys.min() > 0.0 and np.ptp(np.log10(ys)) > DECADES)
        ys = np.log10(ys) if self.log else ys
        self.x_span, self.y_span = _span(xs, 0.0), _span(ys, 0.06)
        near = 0.5 * (self.y_span[1] - self.y_span[0])
        for level in plot.bounds:
            # A bound far off would flatten the curve.
            if self.y_span[0] - near <= level <= self.y_span[1] + near:
                self.y_span = _span(np.array([*self.y_span, level]), 0.02)
        self.title, self.counted = plot.x_title, plot.counted

    def x(self, values: Array) -> Array:
        low, high = self.x_span
        return np.asarray(LEFT + (values - low) / (high - low) * (WIDTH - LEFT - RIGHT))

    def y(self, values: Array) -> Array:
        low, high = self.y_span
        if self.log:
            values = np.log10(np.maximum(values, 10.0**low))
        return np.asarray(TOP + (high - values) / (high - low) * (HEIGHT - TOP - BOTTOM))

    def drawn(self) -> list[str]:
        """Return the grid and its figures."""
        parts = []
        foot = HEIGHT - BOTTOM
        for tick in ticks(*self.y_span, whole=self.log):
            shown = 10.0**tick if self.log else tick
            at = float(self.y(np.array(shown)))
            parts.append(f'<path class="grid" d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}"/>')
            parts.append(
                f'<text x="{LEFT - 5}" y="{at + 3.5:.1f}" text-anchor="end">{figure(shown)}</text>'
            )
        for tick in ticks(*self.x_span, whole=self.counted):
            at = float(self.x(np.array(tick)))
            parts.append(f'<path class="grid" d="M{at:.1f} {TOP}V{foot}"/>')
            parts.append(
                f'<text x="{at:.1f}" y="{foot + 13}" text-anchor="middle">{figure(tick)}</text>'
            )
        middle = 0.5 * (LEFT + WIDTH - RIGHT)
        parts.append(
            f'<text class="title" x="{middle}" y="{HEIGHT - 5}" text-anchor="middle">'
            f"{escape(self.title)}</text>"
        )
        return parts

    def across(self, level: float, look: str) -> list[str]:
        """Return a level from side to side, if it is in the picture."""
        at = self._within(level)
        return (
            [] if at is None else [f'<path class="{look}" d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}"/>']
        )

    def named(self, level: float, name: str, taken: list[float]) -> list[str]:
        """Return a level's name above or below it, where no other name is taken down."""
        at = self._within(level)
        if at is None:
            return []
        places = [
            place
            for place in (at - 3.0, at + 10.0)
            if TOP + 7.0 <= place <= HEIGHT - BOTTOM - 1.0
            and all(abs(place - other) >= 10.0 for other in taken)
        ]
        if not places:
            return []
        taken.append(places[0])
        return [
            f'<text class="name" x="{WIDTH - RIGHT - 2}" y="{places[0]:.1f}" '
            f'text-anchor="end">{escape(name)}</text>'
        ]

    def _within(self, level: float) -> float | None:
        at = float(self.y(np.array(level))) if math.isfinite(level) else -1.0
        return at if TOP - 0.1 <= at <= HEIGHT - BOTTOM + 0.1 else None

    def curve(self, line: PlottedLine) -> list[str]:
        """Return a curve, in pieces where it has gaps."""
        step = max(1, math.ceil(len(line.x) / MOST_POINTS))
        keep = np.unique([*range(0, len(line.x), step), len(line.x) - 1])
        x, y = line.x[keep], line.y[keep]
        fine = np.isfinite(x) & np.isfinite(y)
        xs, ys = self.x(np.where(fine, x, 0.0)), self.y(np.where(fine, y, 1.0))
        path, pen = [], "M"
        for one, a, b in zip(fine, xs, ys, strict=True):
            if not one:
                pen = "M"
                continue
            path.append(f"{pen}{a:.1f} {b:.1f}")
            pen = "L"
        parts = [f'<path class="{escape(line.look)}" d="{"".join(path)}"/>']
        if line.dots:
            parts += [
                f'<circle class="dot" cx="{a:.1f}" cy="{b:.1f}" r="2.6"/>'
                for one, a, b in zip(fine, xs, ys, strict=True)
                if one
            ]
        return parts


def ticks(low: float, high: float, *, whole: bool = False) -> list[float]:
    """Return two to six round levels between two; with `whole` no fractions."""
    raw = (high - low) / 5.0
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(many * power for many in (1.0, 2.0, 5.0, 10.0) if many * power >= raw * 0.999)
    if whole:
        step = max(1.0, round(step))
    first = math.ceil(low / step - 1e-9)
    return [float(f"{step * at:.12g}") for at in range(first, math.floor(high / step + 1e-9) + 1)]


def figure(value: float) -> str:
    """Return a number as short as an axis shows it, with a true minus sign."""
    return f"{value:.4g}".replace("-", "\N{MINUS SIGN}").replace("e+0", "e")


def _all(arrays: Sequence[Array]) -> Array:
    joined = np.concatenate([np.zeros(0), *arrays])
    return np.asarray(joined[np.isfinite(joined)])


def _span(values: Array, room: float) -> tuple[float, float]:
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    if high - low < 1e-9 * max(1.0, abs(low), abs(high)):
        return low - 0.5, high + 0.5
    more = room * (high - low)
    return low - more, high + more
