"""Warm starts from an existing policy: its commands as they are, shifted in time, and scaled."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.policy.policy import Policy
from morph.policy.track import Track
from morph.search.evaluate import attempt
from morph.search.plan.initial_trajectories import SeedInputs, ranked
from morph.search.trajectory.ddp import Trajectories
from morph.sim.simulator import Simulator

SEEN = 3
"""Noisy runs of the old policy beside the one without noise."""

STRETCH, HARDER = 0.3, 0.3
"""How far its commands are stretched in time and scaled: by factors of about exp(+-these)."""


def recalled(
    ground: SeedInputs,
    simulator: Simulator,
    old: Policy,
    *,
    rows: int,
    keep: int,
    rng: np.random.Generator,
) -> Trajectories:
    """Return the best runs under an old policy's commands, and the regulator takes over.

    Args:
        ground: The task and the body as they are now.
        simulator: That body, in which the old policy is run.
        old: What once did this task, or one like it.
        rows: How many stretched and scaled commands are tried beside those as they are.
        keep: How many are given back, at most.
        rng: Chance.
    """
    plain = _plain(ground, simulator, old, rng)
    stretch = np.exp(STRETCH * rng.standard_normal(rows))
    harder = np.exp(HARDER * rng.standard_normal(rows))
    which = rng.integers(0, len(plain), rows)
    varied = np.stack(
        [
            harder[at] * stretched(plain[which[at]], stretch[at], ground.periods)
            for at in range(rows)
        ]
    )
    command = np.clip(np.concatenate([plain, varied]), *ground.bounds)
    order, _ = ranked(ground, ground.quick, command)
    _, runs = ranked(ground, ground.plant, command[order[: 4 * keep]])
    return runs.rows(np.argsort(runs.cost)[:keep])


def _plain(
    ground: SeedInputs, simulator: Simulator, old: Policy, rng: np.random.Generator
) -> Array:
    """Return what an old policy commands now, and once planned, shape (rows, periods, nu)."""
    task, periods = ground.cost.task, ground.periods
    parts = [
        attempt(task, old, simulator, rows=1, rng=None).command[:, :periods],
        attempt(task, old, simulator, rows=SEEN, rng=rng).command[:, :periods],
    ]
    if isinstance(old, Track):
        knots = np.minimum(np.arange(periods), len(old.command) - 1)
        parts.append(np.asarray(old.command)[None, knots])
    return np.concatenate(parts)


def stretched(command: Array, factor: float, periods: int) -> Array:
    """Return commands that take so many times as long, each the mean over its control period.

    Args:
        command: Held through a period each, shape (held, nu); the last is held on.
        factor: How many times as long.
        periods: How many periods are wanted.
    """
    held = len(command)
    total = np.concatenate([np.zeros((1, command.shape[1])), np.cumsum(command, axis=0)])
    edges = np.arange(periods + 1) / factor
    inside = np.stack([np.interp(edges, np.arange(held + 1), each) for each in total.T], axis=1)
    inside += np.maximum(edges - held, 0.0)[:, None] * command[-1]
    return np.asarray(np.diff(inside, axis=0) * factor)
