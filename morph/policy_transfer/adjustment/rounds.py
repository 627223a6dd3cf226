"""Adjusting in rounds: run on the target, learn from all its runs, adjust, and run again."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.errors import TransferError
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment.adjust import (
    AdjustedPolicy,
    AdjustSettings,
    adjusted,
    applied,
)
from morph.policy_transfer.adjustment.adjusted_rollout import most_promising
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.ddp import Plan
from morph.search.search import Problem
from morph.search.target import Experience, Target
from morph.sim.threads import one_thread

MARGINS = (0.0, 0.2, 0.3)
"""Shares of the commands' range that the source's plans leave free: the more, the slower."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AdjustmentRound:
    """One policy, and what it did on the target."""

    policy: Policy
    """What was run."""
    shown: Experience
    """What the target did."""
    made: AdjustedPolicy | None
    """What was adjusted; None for the source's own policy, which comes first."""
    promised: float
    """Share of noisy runs that were foreseen to succeed; nan where nothing was foreseen."""
    seconds: float
    """Wall time that it took to make, s."""


def sources(
    source: SimulatedTask, *, seed: int, margins: Sequence[float] = MARGINS
) -> tuple[Policy, ...]:
    """Return plans for the source that leave ever more of the commands' range free.

    The first is as good as the bounds permit. The others are for a target that needs more than
    the source does: what is added to a command at its bound is lost.
    """
    problem = Problem(task=source.task, simulator=source.simulator)
    return tuple(Plan(margin=margin).run(problem, seed=seed).policy for margin in margins)


def rounds(
    source: SimulatedTask,
    policies: Sequence[Policy],
    target: Target,
    *,
    trials: int,
    rng: np.random.Generator,
    settings: AdjustSettings | None = None,
    until: bool = True,
) -> tuple[AdjustmentRound, ...]:
    """Return every run on the target, the source's own policy first: thesis section 3.3.

    With several policies of the source the first is run and adjusted, and then of all of them,
    each under that adjustment, the one is run that is foreseen to do best.

    Args:
        source: Where the policies were made.
        policies: Policies of the source, the best first.
        target: What to run on.
        trials: Runs on the target after the first.
        rng: Chance of the target's runs and of the source's.
        settings: How to adjust; None for `AdjustSettings()`.
        until: Whether to end with the first run that succeeds.

    Raises:
        TransferError: There is no policy, or the runs are not of such a body.
    """
    if not policies or trials < 0:
        raise TransferError(
            f"there are {len(policies)} policies for {trials} trials",
            where=f"an adjustment for {source.task.robot.name}",
            fix="give one policy or more, and 0 trials or more",
        )
    first = target.trial(policies[0], rng)
    results = [
        AdjustmentRound(policy=policies[0], shown=first, made=None, promised=np.nan, seconds=0.0)
    ]
    while len(results) <= trials and not (until and results[-1].shown.success):
        began = time.perf_counter()
        runs = [each.shown for each in results]
        with one_thread():
            made = adjusted(source, policies[0], runs, rng=rng, settings=settings)
            policy, promised = _chosen(source, made, policies, rng)
        seconds = time.perf_counter() - began
        shown = target.trial(policy, rng)
        results.append(
            AdjustmentRound(
                policy=policy, shown=shown, made=made, promised=promised, seconds=seconds
            )
        )
    return tuple(results)


def _chosen(
    source: SimulatedTask,
    made: AdjustedPolicy,
    policies: Sequence[Policy],
    rng: np.random.Generator,
) -> tuple[Policy, float]:
    """Return the policy to run next, and the share of its runs that are foreseen to succeed."""
    if len(policies) == 1:
        return applied(made.adjustment, policies[0]), np.nan
    policy, scores = most_promising(source, made.adjustment, policies, rng=rng)
    at = next(at for at, each in enumerate(policies) if each is policy.source)
    return policy, scores[at].share


def best(results: Sequence[AdjustmentRound]) -> AdjustmentRound:
    """Return the round that did best on the target: one that succeeded, of the least loss."""
    return min(results, key=lambda each: (not each.shown.success, each.shown.loss))
