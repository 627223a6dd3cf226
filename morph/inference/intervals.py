"""Parameters with 90 % intervals, from the quadratic about a refit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.arrays import Mask
from morph.inference.quadratic import LogPosterior, information
from morph.model.finding import Estimate
from morph.physics.effect import SLIDING, Effect, Parameter

TEMPERATURE = 2.0
"""By what differences of evidence are divided: laws in tables are not those of robots, and errors
are not normal."""
NORMAL90 = 1.645
"""Standard deviations from the middle of a normal distribution to an end of its 90 % interval."""


def estimates(about: LogPosterior) -> tuple[list[Estimate], Mask]:
    """Return each entry of a point with its 90 % interval, and which are known from the runs.

    The interval is the wider of two: by the curvature of the log posterior at its `TEMPERATURE`,
    and by the jackknife over folds, which holds where errors are not as the model of the
    disturbance says. Of what acts in one run alone, as a push, it is that by the curvature.

    Source: Efron 1982, The jackknife, the bootstrap and other resampling plans, eq. 3.5.

    Args:
        about: The quadratic about the likeliest point.
    """
    hypothesis, point = about.hypothesis, about.point
    low, high = hypothesis.low, hypothesis.high
    free, trust = low < high, information(hypothesis)
    slack = 1e-3 * np.minimum(high - low, np.abs(point) + 1e-9)
    at_bound = free & ((point <= low + slack) | (point >= high - slack))
    # An own figure at its bound is still as uncertain as its prior: what shares a scale with it is.
    moving = free & ~(at_bound & (trust == 0.0))
    # What neither readings nor a prior tell may be anything within its bounds, evenly.
    even = np.where(free & (trust == 0.0), 12.0 / np.maximum(high - low, 1e-150) ** 2, 0.0)
    inner = about.inner() + np.diag(even)
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))[moving]
    inverse = np.linalg.pinv(inner[np.ix_(moving, moving)] / np.outer(scale, scale), hermitian=True)
    variance = np.zeros(len(point))
    variance[moving] = np.diag(inverse) / scale**2
    folds = len(about.grams)
    steps = np.stack([about.without_fold(fold).step(moving)[0] for fold in range(folds)])
    jackknife = (folds - 1) / folds * np.sum((steps - steps.mean(axis=0)) ** 2, axis=0)
    # Without the run of a push nothing is known of it.
    passing = [e.passing for e in hypothesis.effects_at(point) for _ in e.free()]
    jackknife[len(hypothesis.knobs) :][passing] = 0.0
    width = NORMAL90 * np.sqrt(np.maximum(TEMPERATURE * variance, jackknife))
    # What the prior alone says leaves its own variance.
    prior_only = moving & (variance * (trust + even) > 0.9)
    stiff = np.maximum(np.diag(inner), 1e-300)
    width = np.where(at_bound, NORMAL90 * np.sqrt(TEMPERATURE / stiff), width)
    results = [
        Estimate(
            value=float(point[at]),
            low90=float(np.clip(point[at] - width[at], low[at], high[at])),
            high90=float(np.clip(point[at] + width[at], low[at], high[at])),
            unit="-",
            bounded=bool(at_bound[at]),
            prior_only=bool(prior_only[at]),
        )
        for at in range(len(point))
    ]
    return results, ~(at_bound | prior_only)


def factors(about: LogPosterior) -> dict[str, Estimate]:
    """Return the factors on the description's own figures, by name; see `estimates`."""
    estimated, _ = estimates(about)
    return {
        knob.name: replace(
            each,
            value=float(np.exp(each.value)),
            low90=float(np.exp(each.low90)),
            high90=float(np.exp(each.high90)),
        )
        for knob, each in zip(about.hypothesis.knobs, estimated, strict=False)
    }


def shifted(estimate: Estimate, reported: Effect, effect: Effect, name: str) -> Estimate:
    """Return an estimate of a part of a run as one of the whole: times count from its start."""
    if reported is effect:
        return estimate
    by = getattr(reported, name) - getattr(effect, name)
    value, low, high = estimate.value + by, estimate.low90 + by, estimate.high90 + by
    return replace(estimate, value=value, low90=low, high90=high)


def widened(estimate: Estimate, known: Parameter, factor: float) -> Estimate:
    """Return an estimate whose interval is so many times as wide, within the parameter's bounds.

    Errors that are larger than a model of the noise has them leave parameters less sure, by the
    root of their ratio.

    Source: McCullagh and Nelder 1989, Generalized Linear Models, section 9.2 (quasi-likelihood).
    """
    low, high = (
        float(np.clip(estimate.value + factor * (end - estimate.value), known.low, known.high))
        for end in (estimate.low90, estimate.high90)
    )
    return replace(estimate, low90=low, high90=high)


def in_units(estimate: Estimate, known: Parameter, slide: bool) -> Estimate:
    """Return an estimate of an entry of a point in the unit of its parameter.

    Args:
        estimate: Of the entry, which is one over a `reciprocal` parameter.
        known: The parameter.
        slide: Whether its joint is a slide.
    """
    if known.reciprocal:
        value, low, high = (
            float(np.clip(1.0 / max(each, 1e-300), known.low, known.high))
            for each in (estimate.value, estimate.high90, estimate.low90)
        )
        estimate = replace(estimate, value=value, low90=low, high90=high)
    return replace(estimate, unit=SLIDING.get(known.unit, known.unit) if slide else known.unit)
