"""What the choice comes to if samples are taken for independent, as a control."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.model.latent.run import Run
from morph.model.transitions import ModelTransitions
from morph.sim.rollout import Variant, rollout
from morph.sim.tangent import apart


def by_transitions(seen: ModelTransitions, noise: Array) -> Array:
    """Return log p of a run up to each sample, each transition by itself, (models, periods)."""
    variance = noise**2 + (seen.carry**2) @ noise**2
    return _normal(seen.miss, variance)


def by_whole_runs(variants: Sequence[Variant], run: Run, noise: Array) -> tuple[Array, Array]:
    """Return log p of a run up to each sample, samples independent about open-loop runs.

    Args:
        variants: The models; they start where the run starts.
        run: What was recorded.
        noise: Standard deviation of each number, shape (2 nv,).

    Returns:
        With the noise as it is, and with each number's variance as it makes the whole run most
        probable under each model, never below the noise; each (models, periods).
    """
    model: Any = variants[0].model
    every = round(run.period / model.opt.timestep)
    command = np.repeat(run.command, every, axis=0)
    count = len(variants)
    q, v = rollout(
        variants,
        np.arange(count),
        np.repeat(run.position[:1], count, axis=0),
        np.repeat(run.velocity[:1], count, axis=0),
        np.repeat(command[None], count, axis=0),
    )
    moved = apart(model, q[:, every::every], run.position[1:])
    miss = np.concatenate([moved, v[:, every::every] - run.velocity[1:]], axis=-1)
    known = np.broadcast_to(noise**2, miss.shape)
    fitted = np.maximum(known, np.mean(miss**2, axis=1, keepdims=True))
    return _normal(miss, known), _normal(miss, fitted)


def _normal(miss: Array, variance: Array) -> Array:
    density = -0.5 * np.sum(miss**2 / variance + np.log(2.0 * np.pi * variance), axis=-1)
    return np.cumsum(density, axis=-1)
