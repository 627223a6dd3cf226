"""One case of the studies of transfer: a changed body, and what the loop and others do on it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from morph.arrays import JSON
from morph.body.load import load
from morph.errors import SearchError
from morph.model.latent.unknowns import turned
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment.rounds import rounds, sources
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.policy_transfer.loop import TransferLoop
from morph.search.ddp import Plan
from morph.search.evaluate import Score, evaluate
from morph.search.gp_ddp import LearnedPlans
from morph.search.search import Problem
from morph.search.target import Simulated
from morph.sim.threads import one_thread
from morph.task.swing_up import swing_up
from morph.task.task import Task

ROWS = 64
"""Noisy runs by which each policy is judged."""

KINDS = {kind.name: kind for kind in EFFECTS}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A body on which a policy of another is tried."""

    body: str
    """The source, by its name on the shelf."""
    figures: Mapping[str, float] = field(default_factory=dict)
    """What is multiplied, by morph's name for it: `length:pole`."""
    effects: tuple[tuple[str, str, float], ...] = ()
    """What acts besides: an effect's name, its place and its first strength."""
    spread: float | None = None
    """Standard deviation of each number of the start; None for the task's own."""

    @property
    def name(self) -> str:
        """What tables call it."""
        said = [f"{name} x{factor:g}" for name, factor in self.figures.items()]
        said += [f"{name}@{place} {value:g}" for name, place, value in self.effects]
        return f"{self.body}: {', '.join(said) or 'unchanged'}"

    def task(self) -> Task:
        """Return the source's task."""
        return self._spread(swing_up(load(self.body)))

    def target(self) -> Simulated:
        """Return the changed body."""
        robot = load(self.body)
        task = self._spread(swing_up(turned(robot, self.figures) if self.figures else robot))
        return Simulated(task=task, simulator=task.simulator(tuple(map(_effect, self.effects))))

    def _spread(self, task: Task) -> Task:
        if self.spread is None:
            return task
        return replace(task, start=replace(task.start, spread=self.spread))


def _effect(said: tuple[str, str, float]) -> Effect:
    name, place, value = said
    effect = KINDS[name].at(place)
    return replace(effect, **{effect.strengths[0]: value})  # type: ignore[type-var]


@lru_cache(maxsize=64)
def source_policy(body: str, seed: int) -> Policy:
    """Return the source's policy: a plan on the body as it is."""
    task = swing_up(load(body))
    return Plan().run(Problem(task=task, simulator=task.simulator()), seed=seed).policy


def judged(target: Simulated, policy: Policy, seed: int) -> Score:
    """Return how a policy does on the target, by runs that nobody learns from."""
    rng = np.random.default_rng([seed, 77])
    with one_thread():
        return evaluate(target.task, policy, target.simulator, rng=rng, rows=ROWS)


def by_loop(case: Case, seed: int, trials: int) -> list[JSON]:
    """Return each trial of the loop: how its policy does, and what the loop took."""
    target = case.target()
    found = TransferLoop(trials=trials, seed=seed).run(
        case.task(), source_policy(case.body, seed), target
    )
    lines = []
    for each in found.rounds:
        lines.append(
            _line(target, each.tried.policy, seed)
            | {
                "origin": each.tried.origin,
                "trial": each.tried.experience.loss,
                "reached": each.tried.experience.success,
                "seconds": each.seconds,
                "found": [] if each.advice is None else _said(each.advice.repair.explained),
            }
        )
    lines.append(_line(target, found.policy, seed) | {"origin": "kept", "of": found.origin})
    return lines


def _said(explained: object) -> list[JSON]:
    return [
        {"name": each.name, "value": each.value, "low90": each.low90, "high90": each.high90}
        for each in explained.differences  # type: ignore[attr-defined]
    ]


def _line(target: Simulated, policy: Policy, seed: int) -> JSON:
    score = judged(target, policy, seed)
    error = float(score.loss.std(ddof=1) / np.sqrt(len(score.loss)))
    return {"loss": score.mean, "error": error, "success": score.share}


def by_adjustment(case: Case, seed: int, trials: int) -> list[JSON]:
    """Return each trial of adjusting alone."""
    target, task = case.target(), case.task()
    source = SimulatedTask(task=task, simulator=task.simulator())
    first = source_policy(case.body, seed)
    policies = (first, *sources(source, seed=seed, margins=(0.2, 0.3)))
    made = rounds(source, policies, target, trials=trials - 1, rng=np.random.default_rng([seed, 5]))
    return [
        _line(target, each.policy, seed)
        | {"trial": each.shown.loss, "reached": each.shown.success, "seconds": each.seconds}
        for each in made
    ]


def by_own(case: Case, seed: int, trials: int) -> list[JSON]:
    """Return the oracle: the best plan on the true body, as far as a search finds it."""
    target, began = case.target(), time.perf_counter()
    try:
        problem = Problem(task=target.task, simulator=target.simulator)
        policy = Plan().run(problem, seed=seed).policy
    except SearchError as error:
        return [{"why": str(error)}]
    return [_line(target, policy, seed) | {"seconds": time.perf_counter() - began}]


def by_nothing(case: Case, seed: int, trials: int) -> list[JSON]:
    """Return the source's policy as it is."""
    return [_line(case.target(), source_policy(case.body, seed), seed)]


def by_scratch(case: Case, seed: int, trials: int) -> list[JSON]:
    """Return each trial of learning from the target's trials alone, its last policy judged."""
    target = case.target()
    problem = Problem(task=target.task, target=target)
    found = LearnedPlans().run(problem, seed=seed, trials=trials)
    tried = [{"loss": each.loss, "success": each.success} for each in found.trials if each.number]
    return [*tried, _line(target, found.policy, seed) | {"origin": "kept"}]


ARMS = {
    "loop": by_loop,
    "adjusted": by_adjustment,
    "own plan": by_own,
    "unadjusted": by_nothing,
    "scratch": by_scratch,
}
"""Who may try on a case: given the case, a seed and the most trials, the lines of its trials."""
