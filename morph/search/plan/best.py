"""The best plan for a task inside a simulator, chosen by how it does in the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from morph.arrays import Array
from morph.search.plan.feedback import feedback
from morph.search.plan.noisy import tried
from morph.search.plan.seeds import Ground, led, swung
from morph.search.trajectory.ddp import Trajectories, ddp

EFFORTS = (1.0, 3.0)
"""What the feedback's commands may cost, in costs of the regulator's."""

FINALISTS = 2
"""Improved plans that are tried in the noise."""

DOUBTFUL, MORE = 0.85, 4
"""Share of runs that succeed from which it is looked at again, by so many times the runs."""

HOPELESS = 3.0
"""A guess that costs so many times the best is not improved."""

FAILURE = 10.0
"""What a run that fails counts beyond its loss, when plans are compared, in mean losses."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Planned:
    """A plan with its feedback, and how it did in the noise."""

    plan: Trajectories
    """One row."""
    gain: Array
    """Shape (periods, m, n)."""
    loss: float
    """Mean loss of noisy runs."""
    success: float
    """Share of them that reached every goal."""

    @property
    def score(self) -> float:
        """What plans are compared by: the loss, and failures on top."""
        return self.loss * (1.0 + FAILURE * (1.0 - self.success))


def planned(
    ground: Ground, *, rows: int, keep: int, most: int, runs: int, rng: np.random.Generator
) -> Planned:
    """Return the best of one round: guesses, improved, each with feedback, tried in the noise.

    Args:
        ground: The task and the body.
        rows: Bang-bang swings that are drawn first.
        keep: Guesses of either kind that are improved.
        most: Most steps of differential dynamic programming.
        runs: Noisy runs by which each is judged.
        rng: Chance.
    """
    guesses = [swung(ground, rows, keep, rng)]
    if ground.plant.model.nu >= ground.plant.model.nv:
        guesses.append(led(ground, keep))
    return refined(ground, joined(guesses), keep=keep, most=most, runs=runs, rng=rng)


def refined(
    ground: Ground,
    guesses: Trajectories,
    *,
    keep: int,
    most: int,
    runs: int,
    rng: np.random.Generator,
) -> Planned:
    """Return the best of some guesses, once improved and tried; the arguments are `planned`'s."""
    order = np.argsort(guesses.cost)[:keep]
    order = order[guesses.cost[order] <= HOPELESS * guesses.cost[order[0]]]
    plans = ddp(ground.plant, ground.cost, guesses.rows(order), margin=ground.margin, most=most)
    best = plans.rows(np.argsort(plans.cost)[:FINALISTS])
    return judged(ground, best, runs=runs, rng=rng)


def judged(ground: Ground, plans: Trajectories, *, runs: int, rng: np.random.Generator) -> Planned:
    """Return the plan and the feedback that do best together in so many noisy runs."""
    gains = [feedback(ground, plans, effort) for effort in EFFORTS]
    gain = np.concatenate(gains)
    plans = joined([plans] * len(gains))
    loss, success = tried(ground, plans, gain, runs, rng)
    found = [
        Planned(
            plan=plans.rows(np.array([at])),
            gain=gain[at],
            loss=float(loss[at].mean()),
            success=float(success[at].mean()),
        )
        for at in range(len(gain))
    ]
    best = min(found, key=lambda each: each.score)
    if not DOUBTFUL <= best.success < 1.0:
        return best
    # One run in thirty that fails may be one in ten or in a hundred: more runs tell.
    loss, success = tried(ground, best.plan, best.gain[None], MORE * runs, rng)
    return replace(best, loss=float(loss.mean()), success=float(success.mean()))


def joined(parts: Sequence[Trajectories]) -> Trajectories:
    """Return all rows of several."""
    return Trajectories(
        **{
            known.name: np.concatenate([getattr(each, known.name) for each in parts])
            for known in fields(Trajectories)
        }
    )
