"""Predicted return of policies on the target, given its model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.policy.policy import Policy
from morph.policy_transfer.repair import TaskModel
from morph.search.evaluate import evaluate
from morph.search.plan.plan_selection import FAILURE
from morph.sim.threads import one_thread

ROWS = 32
"""Noisy runs by which a policy is judged in each model."""


@dataclass(frozen=True, kw_only=True)
class PredictedReturn:
    """What a policy promises."""

    loss: float
    """Mean loss over models and noisy runs."""
    success: float
    """Share of these runs that reach every goal."""

    @property
    def score(self) -> float:
        """What policies are compared by: the loss, and failures on top."""
        return self.loss * (1.0 + FAILURE * (1.0 - self.success))


def foresee(
    policies: Sequence[Policy], models: Sequence[TaskModel], *, seed: int, rows: int = ROWS
) -> tuple[PredictedReturn, ...]:
    """Return what each policy promises in some models, all by the same chance.

    Args:
        policies: What to judge.
        models: Where; each counts alike.
        seed: Of the starts and the noise.
        rows: Runs of each policy in each model.
    """
    losses = np.zeros((len(policies), len(models)))
    shares = np.zeros_like(losses)
    with one_thread():
        for at, model in enumerate(models):
            simulator = model.simulator
            for which, policy in enumerate(policies):
                rng = np.random.default_rng([seed, at])
                result = evaluate(model.task, policy, simulator, rng=rng, rows=rows)
                losses[which, at], shares[which, at] = result.mean, result.share
    return tuple(
        PredictedReturn(loss=float(loss), success=float(share))
        for loss, share in zip(losses.mean(axis=1), shares.mean(axis=1), strict=True)
    )
