"""Parameters with 90 % intervals, from the quadratic about a refit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from morph.arrays import Array, Mask
from morph.inference.quadratic import LogPosterior, information
from morph.model.finding import Estimate
from morph.physics.effect import SLIDING, Effect, Parameter

TEMPERATURE = 2.0
"""By what differences of evidence are divided: laws in tables are not those of robots, and errors
are not normal."""
NORMAL90 = 1.645
"""Standard deviations from the middle of a normal distribution to an end of its 90 % interval."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Uncertainty:
    """How sure each entry of a point is, by the quadratic about it."""

    about: LogPosterior
    """The quadratic about the likeliest point."""
    moving: Mask
    """Entries that are free to move, shape (entries,)."""
    at_bound: Mask
    """Entries at an end of their range, shape (entries,)."""
    prior: Array
    """Precision beforehand: the description's, or that of an even distribution over the bounds,
    shape (entries,)."""
    even: Array
    """The part of `prior` that is of an even distribution, shape (entries,)."""

    @classmethod
    def of(cls, about: LogPosterior) -> Uncertainty:
        """Return how sure the entries of the quadratic's point are."""
        hypothesis, point = about.hypothesis, about.point
        low, high = hypothesis.low, hypothesis.high
        free, trust = low < high, information(hypothesis)
        slack = 1e-3 * np.minimum(high - low, np.abs(point) + 1e-9)
        at_bound = free & ((point <= low + slack) | (point >= high - slack))
        # What neither readings nor a prior tell may be anything within its bounds, evenly.
        wide = 12.0 / np.maximum(high - low, 1e-150) ** 2
        even = np.where(free & (trust == 0.0), wide, 0.0)
        # An own parameter at its bound is still as uncertain as its prior: what shares a scale with
        # it is.
        moving = free & ~(at_bound & (trust == 0.0))
        return cls(about=about, moving=moving, at_bound=at_bound, prior=trust + even, even=even)

    def estimates(self) -> tuple[list[Estimate], Mask]:
        """Return each entry with its 90 % interval, and which are known from the runs.

        The interval is the wider of two: by the curvature of the log posterior at its
        `TEMPERATURE`, and by the jackknife over folds, which holds where errors are not as the
        model of the disturbance says. Of what acts in one run alone, as a push, it is that by the
        curvature.

        Source: Efron 1982, The jackknife, the bootstrap and other resampling plans, eq. 3.5.
        """
        hypothesis, point = self.about.hypothesis, self.about.point
        low, high = hypothesis.low, hypothesis.high
        variance, jackknife = self._variances()
        width = NORMAL90 * np.sqrt(np.maximum(TEMPERATURE * variance, jackknife))
        # What the prior alone says leaves its own variance.
        prior_only = self.moving & (variance * self.prior > 0.9)
        stiff = np.maximum(np.diag(self._inner()), 1e-300)
        width = np.where(self.at_bound, NORMAL90 * np.sqrt(TEMPERATURE / stiff), width)
        results = [
            Estimate(
                value=float(point[at]),
                low90=float(np.clip(point[at] - width[at], low[at], high[at])),
                high90=float(np.clip(point[at] + width[at], low[at], high[at])),
                unit="-",
                bounded=bool(self.at_bound[at]),
                prior_only=bool(prior_only[at]),
            )
            for at in range(len(point))
        ]
        return results, ~(self.at_bound | prior_only)

    def may_be(self, entries: Sequence[int], value: Array) -> bool:
        """Return whether entries may all have certain values, by what the readings say of them.

        That is whether these lie within the 90 % ellipsoid of the entries, all others at their
        likeliest: one component of a force that shows is enough, however wide the others are.

        Args:
            entries: Indices of the entries.
            value: Shape (entries,).
        """
        chosen = np.isin(np.arange(len(self.prior)), entries)
        values, vectors, scale = self._eigen(self.moving & ~chosen)
        readings = self._inner() - np.diag(self.prior)
        across = vectors.T @ (readings[np.ix_(self.moving & ~chosen, chosen)] / scale[:, None])
        precision = readings[np.ix_(chosen, chosen)] - across.T @ (across / values[:, None])
        variance, jackknife = (each[chosen] for each in self._variances())
        # As wide as by the jackknife, where that is wider.
        narrow = TEMPERATURE * variance < jackknife
        share = np.where(narrow, TEMPERATURE * variance / np.where(narrow, jackknife, 1.0), 1.0)
        away = self.about.point[chosen] - np.asarray(value)[np.argsort(entries)]
        square = float(away @ precision @ away) * float(share.min()) / TEMPERATURE
        return square <= float(chi2.ppf(0.9, len(entries)))

    def _inner(self) -> Array:
        return self.about.inner() + np.diag(self.even)

    def _eigen(self, chosen: Mask) -> tuple[Array, Array, Array]:
        """Return eigenvalues, eigenvectors and scale of the precision of some entries.

        The precision is that matrix times the scale on either side.
        """
        inner = self._inner()
        scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))[chosen]
        values, vectors = np.linalg.eigh(inner[np.ix_(chosen, chosen)] / np.outer(scale, scale))
        # Readings only add to the prior: where they say nothing, rounding would.
        least = vectors.T**2 @ (self.prior[chosen] / scale**2)
        return np.maximum(values, least), vectors, scale

    def _variances(self) -> tuple[Array, Array]:
        """Return the variance of each entry by the curvature, and by the jackknife."""
        hypothesis, about, moving = self.about.hypothesis, self.about, self.moving
        values, vectors, scale = self._eigen(moving)
        variance = np.zeros(len(about.point))
        variance[moving] = (vectors**2 @ (1.0 / values)) / scale**2
        folds = len(about.grams)
        steps = np.stack([about.without_fold(fold).step(moving)[0] for fold in range(folds)])
        jackknife = (folds - 1) / folds * np.sum((steps - steps.mean(axis=0)) ** 2, axis=0)
        # Without the run of a push nothing is known of it.
        passing = [e.passing for e in hypothesis.effects_at(about.point) for _ in e.free()]
        jackknife[len(hypothesis.knobs) :][passing] = 0.0
        return variance, jackknife


def estimates(about: LogPosterior) -> tuple[list[Estimate], Mask]:
    """Return `Uncertainty.estimates` of a quadratic."""
    return Uncertainty.of(about).estimates()


def factors(about: LogPosterior) -> dict[str, Estimate]:
    """Return the factors on the description's own parameters, by name; see `Uncertainty`."""
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
