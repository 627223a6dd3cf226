"""The policy's own numbers turned a little, by evolution that begins at the policy."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.fabrication.match.case import Case
from morph.fabrication.match.matcher import Matcher
from morph.fabrication.match.near.near import near
from morph.policy.policy import Policy
from morph.search.cmaes import Adapting
from morph.search.generations.population import tried
from morph.search.plan.plan_selection import FAILURE


@dataclass(frozen=True, kw_only=True)
class Tune(Matcher):
    """CMA-ES over policies near the policy, from a small spread.

    Source: Hansen 2016, The CMA evolution strategy: a tutorial, arXiv 1604.00772.
    """

    name: ClassVar[str] = "evolution from the policy"
    dear: ClassVar[bool] = True

    population: int = 10
    """Policies in a generation."""
    runs: int = 2
    """Noisy runs of each."""
    sigma: float = 0.12
    """How far the first generation reaches, in sides of the cube."""
    every: int = 3
    """After so many generations the middle is proposed."""

    def suits(self, case: Case) -> bool:
        """Return whether there are policies near, and more than one number to turn."""
        family = near(case.policy, case.printed.robot, self.sigma)
        return family is not None and len(family.numbers) > 1

    def proposals(self, case: Case) -> Iterator[Policy]:
        """Yield the middle of every few generations until the time is up."""
        family = near(case.policy, case.printed.robot, self.sigma)
        if family is None:
            return
        sampler = Adapting(family.start, self.sigma, self.population, None)
        number, took = 0, self.population * self.runs * case.each
        while case.left > 2.0 * took:
            begun = time.monotonic()
            number += 1
            rng = np.random.default_rng([case.seed, 2, number])
            points = sampler.ask(self.population, rng)
            policies = [family.policy(point) for point in points]
            result = tried(case.printed, policies, case.bench, runs=self.runs, rng=rng)
            loss = result.loss.mean(axis=1)
            # As plans are compared: a run that fails counts beyond its loss.
            sampler.tell(points, loss * (1.0 + FAILURE * (1.0 - result.success.mean(axis=1))))
            took = time.monotonic() - begun
            case.told(f"generation {number}, least loss {loss.min():.3g}")
            if number % self.every == 0:
                yield family.policy(np.clip(sampler.mean, 0.0, 1.0))
        if number % self.every:
            # The time is up: what the last generations found is not thrown away.
            yield family.policy(np.clip(sampler.mean, 0.0, 1.0))
