"""Two controls for CMA-ES: an evolution strategy with a round spread, and chance alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.search.generations.generations import Generations
from morph.search.search import State


@dataclass(frozen=True, kw_only=True)
class Evolution(Generations):
    """An evolution strategy that adapts how far it reaches, and not in which direction.

    Source: Hansen, Arnold and Auger 2015, Evolution strategies, in Springer Handbook of
    Computational Intelligence, algorithm 44.6: (mu/mu_w, lambda) with a cumulated path.
    """

    name: ClassVar[str] = "evolution"

    def sampler(self, start: Array, sigma: float, state: State | None) -> IsotropicNormal:
        """Return a round normal distribution whose size adapts."""
        return IsotropicNormal(start, sigma, state)


class IsotropicNormal:
    """A normal distribution that is equally wide along every side of the cube.

    Args:
        start: Its middle at first, shape (numbers,).
        sigma: Its standard deviation at first.
        state: What `state` gave, to go on from there.
    """

    def __init__(self, start: Array, sigma: float, state: State | None = None) -> None:
        """Begin, or go on."""
        self.mean = np.array(state["mean"] if state else start, dtype=float)
        self.sigma = float(state["sigma"] if state else sigma)
        self._path = np.array(state["path"] if state else np.zeros_like(self.mean))

    def ask(self, count: int, rng: np.random.Generator) -> Array:
        """Return points within the cube, shape (count, numbers)."""
        around = self.sigma * rng.standard_normal((count, len(self.mean)))
        return np.clip(self.mean + around, 0.0, 1.0)

    def tell(self, points: Array, losses: Array) -> None:
        """Move the middle to the better half, and widen if such moves go on in one direction."""
        size, better = len(self.mean), len(losses) // 2
        weight = math.log(better + 0.5) - np.log(np.arange(1, better + 1))
        weight /= weight.sum()
        mass = 1.0 / float(np.sum(weight**2))
        moved = weight @ points[np.argsort(losses)[:better]] - self.mean
        c = (mass + 2.0) / (size + mass + 5.0)
        self._path = (1.0 - c) * self._path + math.sqrt(c * (2.0 - c) * mass) * moved / self.sigma
        # Under selection by chance the path is as long as a normal vector is on average.
        expected = math.sqrt(size) * (1.0 - 1.0 / (4.0 * size) + 1.0 / (21.0 * size**2))
        longer = float(np.linalg.norm(self._path)) / expected - 1.0
        self.mean = np.clip(self.mean + moved, 0.0, 1.0)
        self.sigma = min(1.0, self.sigma * math.exp(c / (1.0 + c) * longer))

    def state(self) -> dict[str, Array]:
        """Return all that it needs to go on."""
        return {"mean": self.mean, "sigma": np.asarray(self.sigma), "path": self._path}


@dataclass(frozen=True, kw_only=True)
class RandomSearch(Generations):
    """Policies drawn anywhere in the family: what any search must beat."""

    name: ClassVar[str] = "chance"

    def sampler(self, start: Array, sigma: float, state: State | None) -> Anywhere:
        """Return the uniform distribution over the cube."""
        return Anywhere(start)


class Anywhere:
    """The uniform distribution over the unit cube, which learns nothing."""

    def __init__(self, start: Array) -> None:
        """Keep the point to begin with, which stands for the middle."""
        self.mean = start

    def ask(self, count: int, rng: np.random.Generator) -> Array:
        """Return points within the cube, shape (count, numbers)."""
        return rng.uniform(size=(count, len(self.mean)))

    def tell(self, points: Array, losses: Array) -> None:
        """Take no notice."""

    def state(self) -> dict[str, Array]:
        """Return nothing: the search keeps the best point by itself."""
        return {}
