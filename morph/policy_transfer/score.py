"""How good a policy is on a target that can be simulated: 0 for holding still, 1 for the oracle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from morph.errors import MorphError, SearchError
from morph.policy.pattern import pattern
from morph.policy.policy import Policy
from morph.search.evaluate import Score, evaluate
from morph.search.plan.replan import STAGES, again
from morph.search.search import Problem
from morph.search.searches import default, search
from morph.search.target import Simulated
from morph.sim.threads import one_thread

JUDGING = 2**31 - 2
"""Names the chance of the runs that judge, so that it is that of no trial."""

ROWS = 100
"""Noisy runs by which each policy is judged."""

BEATEN = 0.05
"""Share of the loss of a policy searched on the true parameters by which the policy to keep has to
be better for planning there again from it: that takes longer than the search."""

SEARCHED, KEPT, AS_IT_CAME = "searched there", "the policy to keep", "the source's policy"
"""Which policy the oracle is."""


@dataclass(frozen=True, kw_only=True)
class PolicyScores:
    """What policies do on a target over many noisy runs, all by the same chance."""

    still: Score
    """Every command zero."""
    source: Score
    """The source's policy, as it came."""
    final: Score
    """The policy to keep."""
    oracle: Score | None
    """The best policy known there, one searched on the true parameters among them, so that it is
    never worse than what it judges; None if none could be searched there."""
    best: str = SEARCHED
    """Which policy the oracle is."""

    def scores(self) -> dict[str, float | None]:
        """Return all scores of a hop by their names in transfer.json; None: not measured."""
        return {
            "zero_shot": self._of(self.source),
            "final": self._of(self.final),
            "hold_still": self._of(self.still),
            "no_source": None,
            "scratch": None,
            "oracle": None if self.oracle is None else self._of(self.oracle),
        }

    def shares(self) -> dict[str, float]:
        """Return the share of runs in which each reached every goal, by the same names."""
        named = {"zero_shot": self.source, "final": self.final, "hold_still": self.still}
        if self.oracle is not None:
            named["oracle"] = self.oracle
        return {name: one.share for name, one in named.items()}

    def _of(self, one: Score) -> float | None:
        return None if self.oracle is None else score(one.mean, self.still.mean, self.oracle.mean)


UNMEASURED: dict[str, float | None] = dict.fromkeys(
    ("zero_shot", "final", "hold_still", "no_source", "scratch", "oracle")
)
"""The scores of a hop to a target that cannot be simulated."""


def score(loss: float, still: float, oracle: float) -> float | None:
    """Return a loss between those of holding still and of the oracle, 0 to 1, clipped.

    None if the oracle does no better than holding still, so that there is nothing to measure by.
    """
    span = still - oracle
    if not (math.isfinite(span) and span > 0.0):
        return None
    return float(np.clip((still - loss) / span, 0.0, 1.0)) if math.isfinite(loss) else 0.0


def judged(
    target: Simulated, source: Policy, final: Policy, *, seed: int, rows: int = ROWS
) -> PolicyScores:
    """Return how policies do on a simulated target, beside holding still and the oracle.

    Only this looks inside the target, once nothing is left to try on it.

    Args:
        target: The target, with its true parameters.
        source: The source's policy.
        final: The policy to keep.
        seed: Of the oracle's search and of the runs.
        rows: Runs of each.
    """
    task = target.task
    rest = pattern(task.robot, {}, period=task.period)
    known = oracle(target, seed=seed)

    def by(policy: Policy) -> Score:
        rng = np.random.default_rng([seed, JUDGING])
        return evaluate(task, policy, target.simulator, rng=rng, rows=rows)

    with one_thread():
        began = by(source)
        ended = began if final is source else by(final)
        best, which = None, SEARCHED
        if known is not None:
            best = by(known)
            if ended.mean < (1.0 - BEATEN) * best.mean:
                plan = improved(target, final, seed=seed)
                best = best if plan is None else _better(best, by(plan))
            # On a tie it is the one that was searched.
            for name, one in ((KEPT, ended), (AS_IT_CAME, began)):
                if one.mean < best.mean:
                    best, which = one, name
        return PolicyScores(still=by(rest), source=began, final=ended, oracle=best, best=which)


def _better(one: Score, other: Score) -> Score:
    return other if other.mean < one.mean else one


def oracle(target: Simulated, *, seed: int) -> Policy | None:
    """Return the policy that the task's own search finds on the true target; None if none."""
    task = target.task
    try:
        problem = Problem(task=task, simulator=target.simulator)
        return search(default(task.name, task.robot))().run(problem, seed=seed).policy
    except SearchError:
        return None


def improved(target: Simulated, policy: Policy, *, seed: int) -> Policy | None:
    """Return a plan made on the true target from a policy; None if none can be made."""
    try:
        return again(target.task, target.simulator, policy, seed=seed, stages=STAGES[:1]).policy
    except MorphError:
        # Whatever hinders it: the oracle is then the best of the others.
        return None
