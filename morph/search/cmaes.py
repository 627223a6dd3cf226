"""CMA-ES: generations whose spread follows the shape of what was good."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.search.generations.generations import Generations
from morph.search.search import State


@dataclass(frozen=True, kw_only=True)
class CmaEs(Generations):
    """Covariance matrix adaptation, by the library cmaes.

    Source: Hansen 2016, The CMA evolution strategy: a tutorial, arXiv 1604.00772.
    """

    name: ClassVar[str] = "cmaes"

    def sampler(self, start: Array, sigma: float, state: State | None) -> Adapting:
        """Return a distribution that adapts its covariance."""
        return Adapting(start, sigma, self.population, state)


class Adapting:
    """A normal distribution that cmaes keeps, its chance handed in with every generation.

    Args:
        start: Its middle at first, shape (numbers,).
        sigma: Its standard deviation at first.
        population: How many points are told at once.
        state: What `state` gave, to go on from there.
    """

    def __init__(self, start: Array, sigma: float, population: int, state: State | None) -> None:
        """Begin, or go on."""
        from cmaes import CMA

        if len(start) < 2:
            raise SearchError(
                "it has one free number, and a covariance needs two",
                where="search cmaes",
                fix="take the search evolution",
            )
        box = np.tile([0.0, 1.0], (len(start), 1))
        self._cma: Any = CMA(mean=start.copy(), sigma=sigma, bounds=box, population_size=population)
        if state is None:
            return
        # The library hands itself out for pickling as plain numbers and arrays: no pickle is
        # needed to keep those.
        known = self._cma.__getstate__()
        self._cma.__setstate__(
            known
            | {key: _like(known[key], state[f"cma.{key}"]) for key in known if _kept(known[key])}
        )

    @property
    def mean(self) -> Array:
        """The middle of what it proposes next."""
        return np.asarray(self._cma.mean)

    def ask(self, count: int, rng: np.random.Generator) -> Array:
        """Return points within the cube, shape (count, numbers)."""
        self._cma.reseed_rng(int(rng.integers(2**32 - 1)))
        return np.array([self._cma.ask() for _ in range(count)])

    def tell(self, points: Array, losses: Array) -> None:
        """Move the middle towards what cost least, and stretch along what it has in common."""
        self._cma.tell(list(zip(points, losses, strict=True)))

    def state(self) -> dict[str, Array]:
        """Return all that it needs to go on."""
        known = self._cma.__getstate__()
        return {f"cma.{key}": np.asarray(each) for key, each in known.items() if _kept(each)}


def _kept(value: Any) -> bool:
    return isinstance(value, int | float | np.ndarray | np.number)


def _like(before: Any, now: Array) -> Any:
    """Return a stored array as what it was: an array, or one number of Python's."""
    return np.array(now) if isinstance(before, np.ndarray) else type(before)(now)
