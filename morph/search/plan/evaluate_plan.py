"""Evaluate the policy of a search in a simulator over fresh noisy rollouts."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from morph.policy.policy import Policy
from morph.search.evaluate import evaluate
from morph.search.search import Learned, Problem, Told, Trial

ENOUGH = 0.95
"""Share of noisy runs that must reach every goal for a search to count as successful."""


def concluded(
    problem: Problem,
    policy: Policy,
    record: tuple[Trial, ...] | None,
    *,
    seed: int,
    what: str,
    hint: str,
) -> Learned:
    """Return what a search gives back; if it failed, with the reason.

    Args:
        problem: What it was given.
        policy: Its best policy.
        record: Its learning record, empty if all was done before a kill; of None these runs
            become the only line.
        seed: Its seed; these runs have chance of their own.
        what: What the policy is, to begin the reason with.
        hint: What to end the reason with.
    """
    rng = np.random.default_rng([seed, 0])
    score = evaluate(problem.task, policy, problem.model, rng=rng)
    fine = score.share >= ENOUGH
    why = (
        f"{what} reaches every goal in {score.share:.0%} of {len(score.loss)} noisy runs, "
        f"at a mean loss of {score.mean:.3g}; {hint}"
    )
    if record is None:
        record = (Trial(number=1, loss=score.mean, success=score.share, seconds=0.0),)
    return Learned(policy=policy, trials=record, succeeded=fine, why="" if fine else why)


def concluded_at_once(
    problem: Problem,
    policy: Policy,
    *,
    seed: int,
    began: float,
    progress: Told,
    what: str,
    hint: str,
) -> Learned:
    """Return what a search of a single round gives back, and tell that round.

    Args:
        problem: What it was given.
        policy: Its policy.
        seed: Its seed.
        began: When it began, by `time.monotonic`, s.
        progress: Is called with the round.
        what: What the policy is, to begin the reason with if it failed.
        hint: What to end the reason with.
    """
    result = concluded(problem, policy, None, seed=seed, what=what, hint=hint)
    trial = replace(result.trials[0], seconds=time.monotonic() - began)
    progress(trial, {})
    return replace(result, trials=(trial,))
