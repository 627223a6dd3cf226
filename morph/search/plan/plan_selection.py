"""Choose the plan with the least expected cost over noisy rollouts in the simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from morph.arrays import Array, Integers
from morph.search.plan.filtered import along, filtered
from morph.search.plan.initial_trajectories import SeedInputs, led, swung
from morph.search.plan.noisy import tried
from morph.search.trajectory.ddp import Trajectories, ddp
from morph.search.trajectory.plant import Plant

EFFORTS = (1.0, 3.0)
"""What the feedback's commands may cost, in costs of the regulator's, along a receding plan."""

KINDS = (
    (1.0, math.inf),
    (3.0, math.inf),
    (30.0, math.inf),
    (300.0, math.inf),
    (3.0, 0.1),
    (30.0, 0.1),
    (300.0, 0.1),
)
"""What feedback is tried: what its commands may cost, and the doubt of its filter, if it has one.

Where commands are at their bounds for long, noise is fed back one-sidedly: little feedback, or
one that sees past the noise, does better there.
"""

LOOK, GOOD = 12, 3
"""Noisy runs of each feedback at first, and how many of them are looked at more closely."""

FINALISTS = 2
"""Improved plans that are tried in the noise."""

SURE = 0.97
"""Share of the runs by which plans are compared that must, for no further round to begin."""

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
    """On what was seen at each sample and before, shape (periods + 1, m, ages, n); the last holds
    at rest."""
    loss: float
    """Mean loss of noisy runs."""
    success: float
    """Share of them that reached every goal."""

    @property
    def score(self) -> float:
        """What plans are compared by: the loss, and failures on top."""
        return self.loss * (1.0 + FAILURE * (1.0 - self.success))


def planned(
    ground: SeedInputs, *, rows: int, keep: int, most: int, runs: int, rng: np.random.Generator
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
    ground: SeedInputs,
    guesses: Trajectories,
    *,
    keep: int,
    most: int,
    runs: int,
    rng: np.random.Generator,
) -> Planned:
    """Return the best of some guesses, once improved and tried; the arguments are `planned`'s."""
    return judged(ground, sifted(ground, guesses, keep=keep, most=most), runs=runs, rng=rng)


def sifted(ground: SeedInputs, guesses: Trajectories, *, keep: int, most: int) -> Trajectories:
    """Return the best of some guesses, once improved; the arguments are `planned`'s."""
    order = np.argsort(guesses.cost)[:keep]
    order = order[guesses.cost[order] <= HOPELESS * guesses.cost[order[0]]]
    plans = ddp(ground.plant, ground.cost, guesses.rows(order), margin=ground.margin, most=most)
    return plans.rows(np.argsort(plans.cost)[:FINALISTS])


def judged(
    ground: SeedInputs,
    plans: Trajectories,
    *,
    runs: int,
    rng: np.random.Generator,
    plants: Sequence[Plant] = (),
    kinds: Sequence[tuple[float, float]] = KINDS,
) -> Planned:
    """Return the plan and the feedback that do best together in so many noisy runs.

    Args:
        ground: The task and the body.
        plans: What may be followed.
        runs: Noisy runs by which the best few are judged, in all bodies together.
        rng: Chance.
        plants: Bodies in which they are tried; that of the ground if none is given.
        kinds: What feedback is tried: what its commands cost, and the doubt of its filter.
    """
    near = along(ground, plans)
    gain = np.concatenate([filtered(ground, near, *kind) for kind in kinds])
    plans = joined([plans] * len(kinds))
    bodies = tuple(plants) or (ground.plant,)

    def scored(which: Integers, rows: int) -> list[Planned]:
        each = -(-rows // len(bodies))
        results = [
            tried(ground, plans.rows(which), gain[which], each, rng, plant=body) for body in bodies
        ]
        loss = np.mean([one[0].mean(axis=1) for one in results], axis=0)
        success = np.mean([one[1].mean(axis=1) for one in results], axis=0)
        return [
            Planned(
                plan=plans.rows(np.array([at])),
                gain=gain[at],
                loss=float(loss[row]),
                success=float(success[row]),
            )
            for row, at in enumerate(which)
        ]

    which = np.arange(len(gain))
    if len(which) > GOOD:
        first = scored(which, min(LOOK, runs))
        which = np.argsort([each.score for each in first])[:GOOD]
    best = min(scored(which, runs), key=lambda each: each.score)
    if not DOUBTFUL <= best.success < 1.0:
        return best
    # One run in thirty that fails may be one in ten or in a hundred: more runs tell.
    plans, gain = best.plan, best.gain[None]
    return scored(np.zeros(1, dtype=np.int64), MORE * runs)[0]


def joined(parts: Sequence[Trajectories]) -> Trajectories:
    """Return all rows of several."""
    return Trajectories(
        **{
            known.name: np.concatenate([getattr(each, known.name) for each in parts])
            for known in fields(Trajectories)
        }
    )
