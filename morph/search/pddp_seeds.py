"""Commands from which dynamic programming on beliefs begins: the best of many by chance."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.model.gp import GaussianProcess
from morph.search.pddp_belief import BeliefPlant

SWITCHES = 5
"""Most switches between the bounds of a command."""


def seeds(
    plant: BeliefPlant,
    process: GaussianProcess,
    bounds: tuple[Array, Array],
    samples: int,
    keep: int,
    rng: np.random.Generator,
) -> Array:
    """Return the command sequences that cost least on the process' mean.

    Each command switches between its bounds, or rests, at up to five times by chance.

    Returns:
        Shape (keep, periods, actions).
    """
    view = plant.view
    low, high = bounds
    periods, size = view.task.samples - 1, len(low)
    times = np.sort(rng.integers(0, periods, size=(samples, size, SWITCHES)), axis=-1)
    levels = rng.choice([0.0, 0.5, 1.0], p=[0.4, 0.2, 0.4], size=(samples, size, SWITCHES + 1))
    clock = np.arange(periods)
    part = (clock[:, None] >= times[..., None, :]).sum(axis=-1)
    share = np.swapaxes(np.take_along_axis(levels, part, axis=-1), 1, 2)
    command = low + share * (high - low)
    cost = _costs(plant, process, command)
    return np.asarray(command[np.argsort(cost, kind="stable")[:keep]])


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
