"""What is seen of a body before anything is tried on it: few transitions about rest."""

from __future__ import annotations

import numpy as np

from experiments.kin.bodies import Kin
from morph.alignment.belief import Belief, believed, mechanical
from morph.alignment.errors import SamplesError
from morph.alignment.guard import TrialTask
from morph.alignment.samples import Transitions
from morph.policy_transfer.body import Body

MOST = 60
"""Transitions of the target that the guard may see."""

WAYS = {
    "cartpole": (15, 0.1),
    "rider_rigid_driven": (15, 0.1),
    "rider_rigid_passive": (15, 0.1),
    "rider_two_links_driven": (6, 0.03),
    "rider_two_links_passive": (6, 0.03),
    "cart_two_links": (6, 0.03),
    "cart_three_links": (4, 0.03),
    "rider_three_links_driven": (4, 0.01),
}
"""How many commands from one rest, and how large in shares of the bounds, by the family: what
keeps the described body near rest, where a linear model holds."""


NEAR, FAR = 1.0, 2.5
"""Greatest number of a state, rad, m, rad/s or m/s, below which runs grow bolder and beyond which
they are tamed."""

BOLDEST, SHORTEST, LONGEST = 0.4, 4, 20
"""Largest commands, in shares of the bounds, and commands of the shortest and the longest run."""


def moved(
    body: Body, count: int, length: int, share: float, rng: np.random.Generator
) -> Transitions:
    """Return so many transitions in runs of a length, each from rest."""
    found = body.transitions(min(length, count), rng, share=share)
    while (left := count - len(found.state)) > 0:
        found = found.and_also(body.transitions(min(length, left), rng, share=share))
    return found


def seen(kin: Kin, rng: np.random.Generator, *, count: int = MOST) -> Transitions:
    """Return so many transitions of a body, moved at first as its description says it may be.

    A run that stayed near rest is followed by a bolder and longer one, a run that went far by a
    tamer and shorter one.
    """
    length, share = WAYS[kin.family]
    found: Transitions | None = None
    while (left := count - (0 if found is None else len(found.state))) > 0:
        run = kin.body.transitions(min(length, left), rng, share=share)
        found = run if found is None else found.and_also(run)
        far = float(np.abs(run.state).max())
        if far < NEAR:
            share, length = min(BOLDEST, 2.0 * share), min(LONGEST, 3 * length // 2)
        elif far > FAR:
            share, length = 0.5 * share, max(SHORTEST, length // 2)
    if found is None:
        raise SamplesError(
            f"{count} transitions are asked for",
            where=f"what is seen of {kin.name}",
            fix="ask for one or more",
        )
    return found


def belief(body: Body, transitions: Transitions) -> Belief:
    """Return what transitions tell about a body."""
    low, high = body.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    base, lift, wide = mechanical(body.size // 2, half, body.task.period)
    noise = np.full(body.size, max(body.task.noise, 1e-4))
    return believed(transitions, noise=noise, base=base, lift=lift, wide=wide)


def trial(body: Body, rng: np.random.Generator, *, rows: int = 4) -> TrialTask:
    """Return what a run of a body's task is like: where it begins, after the push, is told."""
    q, v = body.task.start.sample(body.task.robot, body.plant.model, rows, rng)
    low, high = body.bounds
    return TrialTask(
        outcome=body.outcome,
        starts=body.state(q, v),
        low=low,
        high=high,
        periods=body.task.samples - 1,
        period=body.task.period,
    )
