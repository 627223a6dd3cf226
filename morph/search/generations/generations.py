"""Searches that try whole generations of policies, and learn from nothing but their losses."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError, StateError
from morph.policy.policy import Policy
from morph.search.evaluate import Score
from morph.search.family.families import family_of
from morph.search.family.family import Family
from morph.search.generations.population import tried
from morph.search.search import Learned, Problem, Search, State, Told, Trial, ignore

CHECKS = 1_000_000
"""Number of the chance of the checks, beyond that of any generation."""

ENOUGH = 0.95
"""Share of the runs at the end in which a policy that succeeded reaches every goal."""


class Sampler(Protocol):
    """What proposes points of the unit cube, and is told what they cost."""

    @property
    def mean(self) -> Array:
        """The middle of what it proposes next, shape (numbers,)."""

    def ask(self, count: int, rng: np.random.Generator) -> Array:
        """Return points, shape (count, numbers)."""

    def tell(self, points: Array, losses: Array) -> None:
        """Learn what points cost, shape (count, numbers) and (count,)."""

    def state(self) -> dict[str, Array]:
        """Return all that it needs to go on."""


@dataclass(frozen=True, kw_only=True)
class Generations(Search):
    """Settings that all searches by generations share."""

    family: Family | None = None
    """Which policies to choose from; None for those that suit the task and the body."""
    generations: int = 100
    """Most generations."""
    population: int = 12
    """Policies in a generation."""
    runs: int = 2
    """Noisy runs of each."""
    checks: int = 32
    """Noisy runs that must all succeed, twice, before the search is content."""
    sigma: float | None = None
    """How far from its middle the first generation reaches, in sides of the cube; None for as
    far as the family says."""
    most_seconds: float = 540.0
    """After how long no new generation begins, s."""

    def __post_init__(self) -> None:
        """Check the settings."""
        sigma = 0.25 if self.sigma is None else self.sigma
        least = min(self.generations, self.runs, self.checks)
        if least < 1 or self.population < 4 or not 0.0 < sigma <= 1.0:
            raise SearchError(
                f"it would try {self.generations} generations of {self.population} policies in "
                f"{self.runs} runs each, {self.checks} at the end, from a sigma of {sigma:g}",
                where=f"search {self.name}",
                fix="give 1 or more, at least 4 policies, and a sigma of at most 1, such as 0.25",
            )

    @abstractmethod
    def sampler(self, start: Array, sigma: float, state: State | None) -> Sampler:
        """Return what proposes points, about a start in the cube or from an earlier state."""

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the best policy found; the search ends early once every check succeeds."""
        task, simulator = problem.task, problem.model
        family = self.family or family_of(task)
        sampler = self.sampler(family.start, self.sigma or family.sigma, state)
        best = Best.of(state, family)
        begun = time.perf_counter() - best.seconds
        record: list[Trial] = []
        for number in range(best.number + 1, (trials or self.generations) + 1):
            # Before the generation: one that was killed after this has nothing to add.
            if best.share == 1.0:
                break
            # Each generation has a chance of its own, so that one that is resumed is the same.
            rng = np.random.default_rng((seed, number))
            points = np.clip(sampler.ask(self.population, rng), 0.0, 1.0)
            if number == 1:
                points[0] = family.start
            policies = [family.policy(point) for point in points]
            score = tried(task, policies, simulator, runs=self.runs, rng=rng)
            losses = score.loss.mean(axis=1)
            sampler.tell(points, losses)
            first = int(losses.argmin())
            if score.success[first].all():
                # Where luck decides, the middle of what did well beats the luckiest.
                point = points[first] if number % 2 else np.clip(sampler.mean, 0.0, 1.0)
                best = best.checked(point, self._twice(family.policy(point), problem, seed))
            best = best.seen(points[first], float(losses[first]))
            best = replace(best, number=number, seconds=time.perf_counter() - begun)
            record.append(best.trial(float(losses[first]), float(losses.mean())))
            progress(record[-1], {**sampler.state(), **best.state()})
            if best.seconds > self.most_seconds:
                break
        return self._learned(best, sampler.mean, family, problem, seed, tuple(record))

    def _twice(self, policy: Policy, problem: Problem, seed: int) -> Score:
        """Return a check, and if all of it succeeds a second one with it.

        One policy in six that fails one run in twenty passes 32 runs by luck; of 64, one in 30.
        """
        check = self._check(policy, problem, (seed, CHECKS))
        if not check.success.all():
            return check
        again = self._check(policy, problem, (seed, CHECKS + 2))
        return Score(
            loss=np.concatenate([check.loss, again.loss], axis=-1),
            success=np.concatenate([check.success, again.success], axis=-1),
        )

    def _check(self, policy: Policy, problem: Problem, seed: tuple[int, int]) -> Score:
        rng = np.random.default_rng(seed)
        return tried(problem.task, [policy], problem.model, runs=self.checks, rng=rng)

    def _learned(
        self,
        best: Best,
        mean: Array,
        family: Family,
        problem: Problem,
        seed: int,
        record: tuple[Trial, ...],
    ) -> Learned:
        """Return the best, judged by starts that chose nothing.

        The middle of the last generation may be better than any that was tried by few runs.
        """
        policies = [family.policy(best.point), family.policy(np.clip(mean, 0.0, 1.0))]
        if best.share == 1.0:
            policies = policies[:1]
        scores = [self._check(each, problem, (seed, CHECKS + 1)) for each in policies]
        at = max(range(len(scores)), key=lambda each: (scores[each].share, -scores[each].mean))
        share = scores[at].share
        why = (
            f"after {best.number} generations of {self.population} policies, the best one reaches "
            f"every goal in {share:.0%} of {self.checks} noisy runs, at a loss of "
            f"{scores[at].mean:.3g}; try more generations, or a family with more numbers"
        )
        succeeded = share >= ENOUGH
        return Learned(
            policy=policies[at],
            trials=record,
            succeeded=succeeded,
            why="" if succeeded else why,
        )


@dataclass(frozen=True, kw_only=True)
class Best:
    """The best point so far, and how far a search has come."""

    point: Array
    """Where it is in the cube, shape (numbers,)."""
    tried: float = math.inf
    """The least mean loss of any generation."""
    loss: float = math.inf
    """Its mean loss in the checks."""
    share: float = 0.0
    """The share of checks in which it reached every goal; 0 if it was not checked."""
    number: int = 0
    """The last generation."""
    seconds: float = 0.0
    """Wall time so far, s."""

    @classmethod
    def of(cls, state: State | None, family: Family) -> Best:
        """Return what a state holds, or a new one at the start.

        Raises:
            StateError: The state is of a search with other numbers.
        """
        if state is None:
            return cls(point=family.start)
        point = np.asarray(state["best.point"])
        if point.shape != (len(family.numbers),):
            raise StateError(
                f"its state has {len(point)} free numbers, and the family {len(family.numbers)}",
                where="a search by generations",
                fix="go on with the task and the settings that it was begun with",
            )
        return cls(
            point=point,
            number=int(state["best.number"]),
            **{
                name: float(state[f"best.{name}"]) for name in ("tried", "loss", "share", "seconds")
            },
        )

    def checked(self, point: Array, score: Score) -> Best:
        """Return the better one of this and a point that was checked."""
        if (score.share, -score.mean) <= (self.share, -self.loss):
            return self
        return replace(self, point=point, loss=score.mean, share=score.share)

    def seen(self, point: Array, loss: float) -> Best:
        """Return the better one of this and a point that was not, as long as no check helped."""
        if loss >= self.tried:
            return self
        return replace(self, point=self.point if self.share else point, tried=loss)

    def trial(self, least: float, mean: float) -> Trial:
        """Return the generation's line of the learning record."""
        return Trial(
            number=self.number,
            loss=self.loss if self.share else self.tried,
            success=self.share,
            seconds=self.seconds,
            note=f"losses of this generation: least {least:.3g}, mean {mean:.3g}",
        )

    def state(self) -> dict[str, Array]:
        """Return it as arrays by name."""
        return {f"best.{name}": np.asarray(value) for name, value in vars(self).items()}
