"""A search run over many seeds, each policy judged by noisy runs that no search has seen."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass

import numpy as np

from morph.arrays import JSON
from morph.body.load import load
from morph.search.evaluate import evaluate
from morph.search.search import Learned, Problem
from morph.search.searches import search
from morph.search.target import Simulated
from morph.task.tasks import task

JUDGES = 100
"""Noisy runs by which each policy is judged."""

MOST_FAILED = 5
"""Of these, how many may fail if the policy is to count as a success."""

APART = 7_000_001
"""Added to a seed for the chance of its judges, which no search draws from."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """One seed of one search."""

    seed: int
    """The seed."""
    seconds: float
    """Wall time of the search, s, from the loaded body to the policy."""
    strict: bool
    """Whether at least 95 of 100 noisy runs reach every goal."""
    share: float
    """Share of the noisy runs that do."""
    loss: float
    """Mean loss of the noisy runs."""
    claimed: bool
    """Whether the search itself says that it succeeded."""
    first_strict_trial: int | None
    """Of a search from trials: the first trial that reached every goal, counted from 1."""
    trial_losses: tuple[float, ...]
    """Of a search from trials: the loss of each policy trial."""
    trial_strict: tuple[bool, ...]
    """Of a search from trials: whether each policy trial reached every goal."""


def run(name: str, task_name: str, body: str, seed: int, *, trials: int | None = None) -> Run:
    """Return what a search finds from one seed, and how it does."""
    wanted = task(task_name, load(body))
    simulator = wanted.simulator()
    way = search(name)()
    problem = Problem(
        task=wanted,
        simulator=None if way.from_trials else simulator,
        target=Simulated(task=wanted, simulator=simulator),
    )
    began = time.perf_counter()
    learned = way.run(problem, seed=seed, trials=trials)
    seconds = time.perf_counter() - began
    rng = np.random.default_rng(seed + APART)
    score = evaluate(wanted, learned.policy, simulator, rng=rng, rows=JUDGES)
    tried = _policy_trials(learned) if way.from_trials else ()
    return Run(
        seed=seed,
        seconds=seconds,
        strict=bool((~score.success).sum() <= MOST_FAILED),
        share=score.share,
        loss=score.mean,
        claimed=learned.succeeded,
        first_strict_trial=next((at for at, (_, good) in enumerate(tried, 1) if good), None),
        trial_losses=tuple(loss for loss, _ in tried),
        trial_strict=tuple(good for _, good in tried),
    )


def _policy_trials(learned: Learned) -> tuple[tuple[float, bool], ...]:
    """Return loss and success of each trial but those with random commands (number 0)."""
    return tuple((each.loss, each.success > 0.5) for each in learned.trials if each.number > 0)


def runs(
    name: str,
    task_name: str,
    body: str,
    seeds: Iterable[int],
    *,
    trials: int | None = None,
    told: Callable[[Run], None] = lambda run: None,
) -> JSON:
    """Return all seeds of a search, and what they amount to."""
    found = []
    for seed in seeds:
        found.append(run(name, task_name, body, seed, trials=trials))
        told(found[-1])
    tried = [each for each in found if each.trial_losses]
    return {
        "search": name,
        "task": task_name,
        "robot": body,
        "runs": [asdict(each) for each in found],
        "seeds": len(found),
        "strict": sum(each.strict for each in found),
        "median_loss": float(np.median([each.loss for each in found])),
        "median_seconds": float(np.median([each.seconds for each in found])),
        "worst_seconds": max(each.seconds for each in found),
        "strict_within": {
            str(most): sum(
                each.first_strict_trial is not None and each.first_strict_trial <= most
                for each in tried
            )
            for most in (1, 2, 3, 4)
        }
        if tried
        else None,
        "median_loss_of_last_trial": float(np.median([each.trial_losses[-1] for each in tried]))
        if tried
        else None,
    }
