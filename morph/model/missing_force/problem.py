"""Runs of a body linearised, and what they say of its figures and of the force on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.information import Information
from morph.model.latent.run import Run
from morph.model.missing_force.fourier_features import FourierFeatures
from morph.model.missing_force.periods import Periods, PeriodSlopes
from morph.model.missing_force.posterior import Reduced, jump_variance, reduced
from morph.model.missing_force.settings import ForceSettings


@dataclass(frozen=True, kw_only=True, eq=False)
class Iterate:
    """What is believed at one time of a fit: figures, weights and the states of every run."""

    point: Array
    """The hypothesis' point."""
    weight: Array
    """Weights of the force's features, shape (joints, features)."""
    states: tuple[Array, ...]
    """The states of each run, (periods + 1, n)."""

    def towards(self, other: Iterate, share: float) -> Iterate:
        """Return what is a share of the way to another."""

        def between(a: Array, b: Array) -> Array:
            return np.asarray(a + share * (b - a))

        return Iterate(
            point=between(self.point, other.point),
            weight=between(self.weight, other.weight),
            states=tuple(between(a, b) for a, b in zip(self.states, other.states, strict=True)),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceProblem:
    """Runs, the body that they are runs of, and what a force on it may depend on."""

    periods: Periods
    """The body."""
    runs: tuple[Run, ...]
    """What was seen of it."""
    noise: Array
    """Standard deviation of the observations, shape (n,)."""
    waves: FourierFeatures
    """What the force looks at, with whatever lengths."""
    unit: Array | None
    """Typical forces of the motion, shape (joints,); None if no force may be missing."""

    def looking(self, chosen: ForceSettings) -> FourierFeatures:
        """Return the waves with the lengths that were chosen."""
        return self.waves.with_lengths(chosen.own_length, chosen.length)

    def jump(self, chosen: ForceSettings) -> Array:
        """Return the variance of what stays unexplained in a period, shape (n,)."""
        noise = self.noise[self.periods.nv :]
        return jump_variance(chosen.jump * noise, self.noise, self.periods.period)

    def prior(self, chosen: ForceSettings) -> tuple[Array, Array]:
        """Return mean and variance of (p, w) before any data."""
        hypothesis = self.periods.hypothesis
        start, variance = hypothesis.start, 1.0 / hypothesis.trust
        if self.unit is None:
            return start, variance
        more = self.waves.variances(chosen.own * self.unit, chosen.whole * self.unit)
        return (
            np.concatenate([start, np.zeros(more.size)]),
            np.concatenate([variance, more.ravel()]),
        )

    def slopes(self, believed: Iterate, chosen: ForceSettings) -> list[PeriodSlopes]:
        """Return all runs, linearised about what is believed."""
        waves = None if self.unit is None else self.looking(chosen)
        return [
            self.periods.slopes(run, state, believed.point, waves, believed.weight)
            for run, state in zip(self.runs, believed.states, strict=True)
        ]

    def cost(
        self, believed: Iterate, slopes: Sequence[PeriodSlopes], chosen: ForceSettings
    ) -> float:
        """Return minus twice the log posterior of a belief, but for its constant."""
        total, jump = 0.0, self.jump(chosen)
        for run, each in zip(self.runs, slopes, strict=True):
            total += float((((run.state - each.state) / self.noise) ** 2).sum())
            total += float((each.missed**2 / jump).sum())
        start, variance = self.prior(chosen)
        weight = np.zeros(0) if self.unit is None else believed.weight.ravel()
        off = np.concatenate([believed.point, weight]) - start
        return total + float((off**2 / variance).sum())

    def reduced(self, slopes: Sequence[PeriodSlopes], chosen: ForceSettings) -> list[Reduced]:
        """Return what each run says of (p, f), its states taken out."""
        jump = self.jump(chosen)
        return [
            reduced(each, run.state, self.noise, jump)
            for each, run in zip(slopes, self.runs, strict=True)
        ]

    def features(self, each: PeriodSlopes, chosen: ForceSettings) -> Array:
        """Return the mean features of each period, shape (periods, joints, count)."""
        return np.asarray(self.looking(chosen).of(each.inside).mean(axis=1))

    def told(
        self, slopes: Sequence[PeriodSlopes], parts: Sequence[Reduced], chosen: ForceSettings
    ) -> list[Information]:
        """Return what each run says of (p, w), whatever lengths its slopes were taken with."""
        if self.unit is None:
            size = len(slopes[0].point)
            return [part.information.through(np.eye(len(part.about), size)) for part in parts]
        pairs = zip(slopes, parts, strict=True)
        return [part.through(self.features(each, chosen)) for each, part in pairs]

    def posterior(
        self, slopes: Sequence[PeriodSlopes], parts: Sequence[Reduced], chosen: ForceSettings
    ) -> Information:
        """Return what is known of (p, w) by all runs and the prior."""
        given = self.told(slopes, parts, chosen)
        return sum(given[1:], given[0]).with_prior(*self.prior(chosen))


def typical_forces(slopes: Sequence[PeriodSlopes]) -> Array:
    """Return the forces that change velocities as they change in the runs, shape (joints,)."""
    results = []
    for each in slopes:
        nv = each.of_force.shape[2]
        change = np.diff(each.state[:, nv:], axis=0)
        results.append(np.linalg.solve(each.of_force[:, nv:], change[..., None])[..., 0])
    return np.asarray(np.sqrt((np.concatenate(results) ** 2).mean(axis=0)) + 1e-9)
