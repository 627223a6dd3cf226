"""Initial commands for dynamic programming on distributions: the best of many random ones."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.plant import BeliefPlant

SWITCHES = 5
"""Most switches between the bounds of a command."""

ROUNDS = 5
"""How often sequences near the best are tried."""

ELITES = 40
"""How many of the best."""

SHIFT = 2.0
"""Standard deviation of how much a switch is shifted each time, in control periods."""

LEVELS = (0.0, 0.5, 1.0)
"""Shares of the command's range between which it switches."""


def seeds(
    plant: BeliefPlant,
    process: GaussianProcess,
    bounds: tuple[Array, Array],
    samples: int,
    keep: int,
    rng: np.random.Generator,
) -> Array:
    """Return the command sequences that cost least on the process' mean.

    Each command switches between its bounds, or rests, at up to five times by chance; then
    some times around the best ones.

    Returns:
        Shape (keep, periods, actions).
    """
    view, (low, high) = plant.view, bounds
    periods, size = view.task.samples - 1, len(low)
    times = np.sort(rng.integers(0, periods, size=(samples, size, SWITCHES)), axis=-1)
    levels = rng.integers(0, len(LEVELS), size=(samples, size, SWITCHES + 1))

    def told(times: Integers, levels: Integers) -> Array:
        part = (np.arange(periods)[:, None] >= times[..., None, :]).sum(axis=-1)
        share = np.take_along_axis(np.array(LEVELS)[levels], part, axis=-1)
        return np.asarray(low + np.swapaxes(share, 1, 2) * (high - low))

    cost = _costs(plant, process, told(times, levels))
    for _ in range(ROUNDS):
        best = np.argsort(cost, kind="stable")[: min(ELITES, samples)]
        each = best[rng.integers(0, len(best), size=max(samples // ROUNDS, 1))]
        shifted = times[each] + np.rint(rng.normal(scale=SHIFT, size=times[each].shape))
        new_times = np.sort(np.clip(shifted, 0, periods), axis=-1).astype(np.int64)
        other = rng.integers(0, len(LEVELS), size=levels[each].shape)
        new_levels = np.where(rng.random(other.shape) < 0.1, other, levels[each])
        cost = np.concatenate([cost[best], _costs(plant, process, told(new_times, new_levels))])
        times = np.concatenate([times[best], new_times])
        levels = np.concatenate([levels[best], new_levels])
    first = np.argsort(cost, kind="stable")
    return told(times[first[:keep]], levels[first[:keep]])


def _costs(plant: BeliefPlant, process: GaussianProcess, command: Array) -> Array:
    """Return what rows of commands cost on the mean, shape (rows,)."""
    view = plant.view
    h, joints = view.task.period, view.joints
    state = np.tile(view.start[0], (len(command), 1))
    states = [state]
    for at in range(command.shape[1]):
        inputs = np.concatenate([view.lifted(state), command[:, at]], axis=1)[:, view.looks]
        change = process.mean(inputs)
        q, v = state[:, :joints], state[:, joints:]
        state = np.concatenate([q + h * (v + 0.5 * change), v + change], axis=1)
        states.append(state)
    mean = np.stack(states, axis=1)
    none = np.zeros((*mean.shape, mean.shape[-1]))
    return plant.costs(mean, none, command)
