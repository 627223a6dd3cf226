"""Parameters of a radial basis function policy as one vector."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.policy.policy import Policy
from morph.policy.radial import Radial
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.task import TaskSums
from morph.search.moments.radial import RadialNumbers

SMALLEST = 0.1
"""Least spread of a feature."""

WIDEST = 3.0
"""How far the logarithm of a width may run from that of the feature's spread."""

FAR = 5.0
"""How far a centre may be from the middle, and a weight from 0, in spreads and half ranges."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RadialScale:
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


def scale_of(view: TaskSums, memory: Memory, units: int) -> RadialScale:
    """Return the units in which a search moves: spreads of the features that were seen."""
    features = memory.features(view)
    spread = features.std(axis=0)
    return RadialScale(
        units=units,
        actions=len(view.action),
        seen=features,
        middle=features.mean(axis=0),
        spread=np.where(spread > SMALLEST, spread, SMALLEST),
    )


def radial_of(view: TaskSums, numbers: RadialNumbers) -> Policy:
    """Return the policy that these numbers make."""
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
