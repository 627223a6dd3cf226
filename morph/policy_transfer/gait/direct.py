"""Learning a gait from nothing: the search that a chain is held against, and what is best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.policy_transfer.gait.mover import Mover
from morph.search.cmaes import CmaEs
from morph.search.family.family import Family


@dataclass(frozen=True, kw_only=True, eq=False)
class GaitSearchResult:
    """What a search found, trial by trial."""

    point: Array
    """The points of the cube that were tried, in order, shape (trials, numbers)."""
    speed: Array
    """How fast each went, m/s, shape (trials,)."""

    @property
    def best(self) -> float:
        """The greatest speed, m/s."""
        return float(self.speed.max())

    def trials_to(self, speed: float) -> int | None:
        """Return how many trials it took to reach a speed; None if it never did."""
        reached = self.speed >= speed
        return int(reached.argmax()) + 1 if reached.any() else None


def direct(
    mover: Mover,
    family: Family,
    *,
    trials: int,
    sigma: float,
    seed: int,
    population: int = 10,
    start: Array | None = None,
) -> GaitSearchResult:
    """Return what CMA-ES finds in a family, from the family's start if no other is given.

    Args:
        mover: The body.
        family: What is searched.
        trials: Runs, rounded up to whole generations.
        sigma: How far the first generation reaches, in sides of the cube.
        seed: Chance begins from it.
        population: Runs in a generation.
        start: Where it begins, a point of the cube.
    """
    begin = family.start if start is None else start
    sampler = CmaEs(population=population).sampler(begin, sigma, None)
    points: list[Array] = []
    speeds: list[Array] = []
    for number in range(-(-trials // population)):
        requested = sampler.ask(population, np.random.default_rng((seed, number, 5)))
        requested = np.clip(requested, 0.0, 1.0)
        if number == 0:
            requested[0] = begin
        gone = mover.speed([family.policy(each) for each in requested])
        sampler.tell(requested, -gone)
        points.append(requested)
        speeds.append(gone)
    return GaitSearchResult(
        point=np.concatenate(points)[:trials], speed=np.concatenate(speeds)[:trials]
    )
