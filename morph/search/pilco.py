"""PILCO: a policy improved by the gradient of its expected loss on what is believed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import minimize

from morph.arrays import Array
from morph.model.gp import GaussianProcess
from morph.policy.policy import Policy
from morph.policy.radial import Radial
from morph.search.belief_laws import RadialLaw
from morph.search.belief_memory import Memory
from morph.search.belief_rollout import imagine
from morph.search.belief_search import BeliefSearch, Improved
from morph.search.belief_task import View
from morph.search.moments_radial import RadialNumbers

SMALLEST = 0.1
"""Least spread of a feature."""

WIDEST = 3.0
"""How far the logarithm of a width may run from that of the feature's spread."""

FAR = 5.0
"""How far a centre may be from the middle, and a weight from 0, in spreads and half ranges."""


@dataclass(frozen=True, kw_only=True)
class Pilco(BeliefSearch):
    """Radial basis functions, improved by L-BFGS on the analytic gradient.

    Source: Deisenroth and Rasmussen 2011, PILCO: A Model-Based and Data-Efficient Approach to
    Policy Search, ICML, algorithm 1; with one length for all basis functions of a feature.
    """

    name: ClassVar[str] = "pilco"

    units: int = 30
    """Basis functions."""
    steps: int = 100
    """Most steps of the search for a better policy, after each trial."""
    short: int = 25
    """Steps after which the best of several starts is chosen."""
    starts: int = 2
    """Policies from which each search begins: the one before, and others by chance."""

    def improved(
        self, view: View, process: GaussianProcess, memory: Memory, rng: np.random.Generator
    ) -> Improved:
        """Return the policy of the least expected loss that was found."""
        plant, (m, S) = view.plant(process), view.start
        periods = view.task.samples - 1
        scale = self._scale(view, memory)

        def cost(numbers: Array) -> tuple[float, Array]:
            law = RadialLaw(scale.numbers(numbers))
            found = imagine(plant, law, view.costs, m, S, periods)
            return float(found.loss), found.gradient * scale.slope

        begun = [scale.packed(memory.numbers)] if memory.numbers is not None else []
        while len(begun) < self.starts:
            begun.append(scale.drawn(rng))
        tried = [_descended(cost, start, scale, self.short) for start in begun]
        best = min(tried, key=lambda run: run[0])
        value, numbers = _descended(cost, best[1], scale, self.steps)
        found = scale.numbers(numbers)
        return Improved(
            policy=_policy(view, found), numbers=scale.unpacked(numbers), expected=value
        )

    def _scale(self, view: View, memory: Memory) -> Scale:
        """Return the units in which the search moves: spreads of the features that were seen."""
        features = memory.features(view)
        spread = features.std(axis=0)
        return Scale(
            units=self.units,
            actions=len(view.action),
            seen=features,
            middle=features.mean(axis=0),
            spread=np.where(spread > SMALLEST, spread, SMALLEST),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Scale:
    """One vector for all numbers of a policy, near 1 each, so that one step suits all."""

    units: int
    """Basis functions."""
    actions: int
    """Commands."""
    seen: Array
    """Features that were seen, shape (samples, features)."""
    middle: Array
    """Their mean, shape (features,)."""
    spread: Array
    """Their standard deviation, shape (features,)."""

    @property
    def _cuts(self) -> tuple[int, int]:
        first = self.units * len(self.spread)
        return first, first + len(self.spread)

    @property
    def slope(self) -> Array:
        """Derivative of each number of the policy in that of the vector, shape (numbers,)."""
        rest = len(self.spread) + self.actions * self.units
        return np.concatenate([np.tile(self.spread, self.units), np.ones(rest)])

    @property
    def shift(self) -> Array:
        """The policy's numbers where the vector is zero, shape (numbers,)."""
        return np.concatenate(
            [
                np.tile(self.middle, self.units),
                np.log(self.spread),
                np.zeros(self.actions * self.units),
            ]
        )

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """How far each number of the vector may go."""
        first, second = self._cuts
        far = [FAR] * first + [WIDEST] * (second - first) + [FAR] * (self.actions * self.units)
        return [(-each, each) for each in far]

    def unpacked(self, vector: Array) -> Array:
        """Return the policy's numbers of a vector."""
        return np.asarray(vector * self.slope + self.shift)

    def packed(self, numbers: Array) -> Array:
        """Return the vector of the policy's numbers."""
        return np.asarray((numbers - self.shift) / self.slope)

    def numbers(self, vector: Array) -> RadialNumbers:
        """Return centres, logarithms of widths, and weights."""
        first, second = self._cuts
        plain = self.unpacked(vector)
        return RadialNumbers(
            centre=plain[:first].reshape(self.units, -1),
            width=plain[first:second],
            weight=plain[second:].reshape(self.actions, self.units),
        )

    def drawn(self, rng: np.random.Generator) -> Array:
        """Return a policy by chance, its units about where the body was."""
        at = rng.integers(len(self.seen), size=self.units)
        centre = (self.seen[at] - self.middle) / self.spread
        centre = centre + 0.5 * rng.standard_normal(centre.shape)
        weight = 0.3 * rng.standard_normal(self.actions * self.units)
        return np.concatenate([centre.ravel(), np.full(len(self.spread), 0.4), weight])


def _descended(
    cost: Callable[[Array], tuple[float, Array]], start: Array, scale: Scale, steps: int
) -> tuple[float, Array]:
    """Return the least cost that L-BFGS finds in so many steps, and where."""
    run = minimize(
        cost,
        np.clip(start, *np.array(scale.bounds).T),
        jac=True,
        method="L-BFGS-B",
        bounds=scale.bounds,
        options={"maxiter": steps, "maxfun": 2 * steps, "maxcor": 20},
    )
    return float(run.fun), np.asarray(run.x)


def _policy(view: View, numbers: RadialNumbers) -> Policy:
    return Radial(
        centre=numbers.centre,
        width=np.exp(numbers.width),
        weight=numbers.weight,
        angles=view.angles,
        bound="sine",
        action=view.action,
        period=view.task.period,
        observation=view.observation,
    )
