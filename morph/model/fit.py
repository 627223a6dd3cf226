"""Joint refit of a robot's own parameters and an effect's parameters by multiple shooting."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.errors import EffectError
from morph.model.deadline import NEVER, Deadline
from morph.model.hypothesis import Hypothesis
from morph.model.segments import Segments
from morph.model.shooting import (
    Sensitivity,
    loss,
    predict,
    quadratic,
    residual,
    sensitivity,
)

SHARES = (1.0, 0.3)
"""Shares of a Gauss-Newton step that are tried, all in one batch."""
DAMPED = (1e-3, 3e-2, 1.0)
"""Levenberg-Marquardt dampings that are tried beside them: they turn the step out of a
narrow valley, where shares of it only shorten it."""
TOLERANCE = 2e-3
"""Relative gain in cost below which a fit stops."""
LIKE = 0.1
"""The same of a step after which exact derivatives still hold."""


@dataclass(frozen=True, kw_only=True)
class PointBounds:
    """Where a point may lie and what it costs to stray."""

    low: Array
    """The least value of each entry."""
    high: Array
    """The greatest value of each entry."""
    trust: Array
    """One over the variance of each entry about its centre."""
    centre: Array
    """What each entry is before any data."""

    def price(self, point: Array) -> float:
        """Return what a point costs for straying from the centre."""
        return float((self.trust * (point - self.centre) ** 2).sum())

    def best_change(
        self, hessian: Array, slope: Array, point: Array, damping: float = 1e-9
    ) -> Array:
        """Return the change d that minimises d.H.d - 2 g.d plus the price, within bounds.

        Entries that would leave their bounds are held there and the rest solved again.
        Damping adds that share of H's diagonal (Marquardt 1963, SIAM J. 11(2), eq. 18).
        """
        whole = hessian + np.diag(self.trust)
        whole = whole + np.diag(damping * np.diag(whole) + 1e-12)
        pull = slope - self.trust * (point - self.centre)
        low, high = self.low - point, self.high - point
        change, held = np.zeros_like(point), np.zeros(len(point), dtype=bool)
        for _ in range(len(point) + 1):
            free = ~held
            if not free.any():
                break
            right = pull[free] - whole[np.ix_(free, held)] @ change[held]
            change[free] = np.linalg.solve(whole[np.ix_(free, free)], right)
            outside = free & ((change < low) | (change > high))
            if not outside.any():
                break
            change = np.where(outside, np.clip(change, low, high), change)
            held |= outside
        return np.clip(change, low, high)


def room(hypothesis: Hypothesis, point: Array) -> PointBounds:
    """Return a hypothesis' room: knobs are drawn to the description, most effects to nowhere."""
    return PointBounds(
        low=hypothesis.low,
        high=hypothesis.high,
        trust=hypothesis.trust,
        centre=np.where(np.isnan(hypothesis.likely), point, hypothesis.likely),
    )


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A hypothesis fitted to segments."""

    hypothesis: Hypothesis
    """What was fitted."""
    point: Array
    """Where it ended, shape (parameters,)."""
    start: Array
    """The segments' starts as measured, shape (segments, nq + nv)."""
    scale: Array
    """Unit of each channel's error, shape (channels,)."""
    weight: Array
    """Of each segment's loss, shape (segments,)."""
    around: Sensitivity
    """The error and its derivatives at the point."""


def fit(
    hypothesis: Hypothesis,
    segments: Segments,
    scale: Array,
    weight: Array,
    *,
    point: Array | None = None,
    start: Array | None = None,
    around: Sensitivity | None = None,
    iterations: int = 6,
    deadline: Deadline = NEVER,
) -> Fit:
    """Fit a hypothesis to segments by Gauss-Newton steps with batched line searches.

    Derivatives are differences of rollouts where the fit begins and where secants gain no more.
    In between each step's errors update them.

    Args:
        hypothesis: What to fit.
        segments: What to fit it to.
        scale: Unit of each channel's error, shape (channels,).
        weight: Of each segment's loss, shape (segments,).
        point: Where to begin; default the hypothesis' own start.
        start: The segments' starts to begin with; default as smoothed.
        around: Error and derivatives at `point` and `start`, where they are known.
        iterations: Most steps.
        deadline: After which no step begins.
    """
    point = hypothesis.start if point is None else point
    point = np.clip(point, hypothesis.low, hypothesis.high)
    start = segments.start if start is None else start
    space = room(hypothesis, point)
    if around is None:
        around = sensitivity(hypothesis, segments, point, start, scale)
    for _ in range(iterations):
        if deadline.passed:
            break
        exact, curve = around.exact, quadratic(segments, around, weight)
        total = curve.hessian.sum(axis=0), curve.slope.sum(axis=0)
        change = space.best_change(*total, point)
        tried = [(share * change, share) for share in SHARES]
        tried += [(space.best_change(*total, point, damping), 1.0) for damping in DAMPED]
        tried = [one for one in tried if _possible(hypothesis, point + one[0])]
        if not tried:
            break
        points = [point + moved for moved, _ in tried]
        steps = [curve.start_change(moved, share) for moved, share in tried]
        starts = [segments.moved(start, step) for step in steps]
        read = predict(hypothesis, segments, points, starts)
        costs = [
            (weight * loss(segments, r, s, scale)).sum() + space.price(p)
            for r, s, p in zip(read, starts, points, strict=True)
        ]
        best = int(np.argmin(costs))
        cost = (weight * around.loss(segments)).sum() + space.price(point)
        gained = cost - costs[best]
        if gained > 0.0:
            error = residual(segments, read[best], scale).reshape(len(segments), -1)
            around = around.after(points[best] - point, error, starts[best], steps[best])
            around = replace(around, exact=exact and gained < LIKE * cost)
            point, start = points[best], starts[best]
        if gained < TOLERANCE * cost:
            if exact:
                break
            around = sensitivity(hypothesis, segments, point, start, scale)
    return Fit(
        hypothesis=hypothesis.moved_to(point),
        point=point,
        start=start,
        scale=scale,
        around=around,
        weight=weight,
    )


def _possible(hypothesis: Hypothesis, point: Array) -> bool:
    """Return whether a point can be simulated: contact may be too stiff for a step."""
    try:
        hypothesis.at(point)
    except EffectError:
        return False
    return True


def measure(segments: Segments, predicted: Array) -> tuple[Array, Array]:
    """Return the unit of each joint's error, and each segment's weight.

    The unit is the root mean square error, never below the noise. A segment whose
    error is many times the typical one is weighed down (as by Geman and McClure 1985),
    so that one bad run does not decide. All are weighed down alike where errors exceed
    the noise: such errors are not independent from one reading to the next but only
    within the band of the motion, and would else outvote the trust in the description.

    Returns:
        Units (joints,) and weights (segments,).
    """
    squared = np.where(segments.valid, (segments.reading - predicted) ** 2, 0.0)
    of_segments = squared.sum(axis=1) / segments.counts
    weight = np.ones(len(segments))
    for _ in range(5):
        mean = (weight[:, None] * of_segments).sum(axis=0) / weight.sum()
        in_units = (of_segments / np.maximum(mean, segments.noise**2)).mean(axis=1)
        weight = 1.0 / (1.0 + in_units / (3.0 * max(float(np.median(in_units)), 1e-12))) ** 2
        weight = weight / weight.max()
    scale = np.maximum(np.sqrt(mean), segments.noise)
    seconds = len(segments) * segments.steps * segments.step
    rate = segments.valid.sum() / len(segments.read) / seconds
    band = max(episode.cutoff for episode in segments.episodes)
    white = float(np.mean((segments.noise / scale) ** 2))
    return scale, weight * float(np.clip(white, min(1.0, 2.0 * band / rate), 1.0))
