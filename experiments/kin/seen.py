"""What is seen of a body before anything is tried on it: few transitions about rest."""

from __future__ import annotations

import numpy as np

from align.belief import Belief, believed, mechanical
from align.guard import Trial
from align.samples import Transitions
from experiments.kin.bodies import Kin
from morph.transfer.body import Body

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


def moved(
    body: Body, count: int, length: int, share: float, rng: np.random.Generator
) -> Transitions:
    """Return so many transitions in runs of a length, each from rest."""
    found = body.transitions(min(length, count), rng, share=share)
    while (left := count - len(found.state)) > 0:
        found = found.and_also(body.transitions(min(length, left), rng, share=share))
    return found


def seen(kin: Kin, rng: np.random.Generator, *, count: int = MOST) -> Transitions:
    """Return so many transitions of a body, moved as its family's description says it may be."""
    return moved(kin.body, count, *WAYS[kin.family], rng)


def belief(body: Body, transitions: Transitions) -> Belief:
    """Return what transitions tell about a body."""
    low, high = body.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    base, lift, wide = mechanical(body.size // 2, half, body.task.period)
    noise = np.full(body.size, max(body.task.noise, 1e-4))
    return believed(transitions, noise=noise, base=base, lift=lift, wide=wide)


def trial(body: Body, rng: np.random.Generator, *, rows: int = 4) -> Trial:
    """Return what a run of a body's task is like: where it begins, after the push, is told."""
    q, v = body.task.start.sample(body.task.robot, body.plant.model, rows, rng)
    low, high = body.bounds
    return Trial(
        outcome=body.outcome,
        starts=body.state(q, v),
        low=low,
        high=high,
        periods=body.task.samples - 1,
        period=body.task.period,
    )
