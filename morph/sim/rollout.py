"""Many simulations at once: variants of one robot, each row one start and one command."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from morph.arrays import Array, Integers
from morph.errors import SimulationFailed
from morph.physics.effect import Effect
from morph.physics.fluid.settle import batches
from morph.physics.stacked import stacked
from morph.sim.one_by_one import one_by_one
from morph.sim.rows import Rows
from morph.sim.threads import batch_threads


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One version of a robot: a compiled model, and the effects it cannot hold."""

    model: Any
    """A `mujoco.MjModel`, every effect's `edit` applied."""
    effects: tuple[Effect, ...]
    """All effects, also those that the model holds already."""


def rollout(
    variants: Sequence[Variant],
    which: Integers,
    position: Array,
    velocity: Array,
    command: Array,
    *,
    states: Mapping[int, Any] = MappingProxyType({}),
    strict: bool = False,
) -> tuple[Array, Array]:
    """Return positions and velocities of many simulations, started and driven as told.

    Args:
        variants: Versions of one robot; all compile to the same sizes.
        which: The variant of each row, shape (rows,).
        position: Where each row starts, shape (rows, nq).
        velocity: How fast, shape (rows, nv).
        command: Controls, constant over each step, shape (rows, steps, nu).
        states: What some effects remember, by their index in a variant; the others start with
            their initial state.
        strict: Whether an unstable row is an error instead.

    Returns:
        Positions (rows, steps + 1, nq) and velocities (rows, steps + 1, nv), the
        start included. A row that became unstable repeats its last state.

    Raises:
        SimulationFailed: MuJoCo refused to step, or with `strict` a row became unstable.
    """
    rows, steps = command.shape[:2]
    if not all(batches(variant.model) for variant in variants):
        with quiet():
            return _without_kernel(variants, which, position, velocity, command, strict)
    batch = Batch(variants[0].model, rows, batch_threads(rows))
    if len(variants) == 1:
        batch.set_models(variants[0].model)
    else:
        batch.set_models([variants[index].model for index in which])
    batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
    batch.bind("qpos")[:] = position
    batch.bind("qvel")[:] = velocity
    try:
        with quiet():
            if any(effect.stepped for effect in variants[0].effects):
                q, v = _step_by_step(batch, variants, which, command, states)
            else:
                out = batch.rollout(steps, command, record=("qpos", "qvel"))
                q, v = out["qpos"], out["qvel"]
    except SimulationError as error:
        raise SimulationFailed(
            f"MuJoCo stopped: {error}",
            where=f"a batch of {rows} simulations of {steps} steps",
            fix="check the robot's masses and inertias, or take a smaller step",
        ) from error
    # Of each warning MuJoCo keeps the last one's information and their number.
    if strict and batch.warning[..., 1].any():
        raise SimulationFailed(
            "the simulation became unstable",
            where=f"{steps} steps of {batch.model.opt.timestep:g} s",
            fix="take a smaller step, or check masses, starts, commands and effects",
        )
    q = np.concatenate([position[:, None], q], axis=1)
    v = np.concatenate([velocity[:, None], v], axis=1)
    return q, v


def _without_kernel(
    variants: Sequence[Variant],
    which: Integers,
    position: Array,
    velocity: Array,
    command: Array,
    strict: bool,
) -> tuple[Array, Array]:
    if any(effect.stepped for effect in variants[0].effects):
        raise SimulationFailed(
            "an effect that acts before every step needs the compiled fluid",
            where="a simulation in a fluid, which runs in numpy here",
            fix="install a C compiler, or `pip install ziglang`, which brings one",
        )
    models = [variants[index].model for index in which]
    return one_by_one(models, position, velocity, command, strict=strict)


@contextmanager
def quiet() -> Iterator[None]:
    """Send MuJoCo's own warnings to our log, not to the terminal and a file of its own."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(logging.getLogger("morph.sim").info)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _step_by_step(
    batch: Batch,
    variants: Sequence[Variant],
    which: Integers,
    command: Array,
    known: Mapping[int, Any],
) -> tuple[Array, Array]:
    rows, steps = command.shape[:2]
    seen = Rows(batch, float(batch.model.opt.timestep))
    slots = [slot for slot, effect in enumerate(variants[0].effects) if effect.stepped]
    acting = [stacked([variants[index].effects[slot] for index in which]) for slot in slots]
    states = [
        known[slot] if slot in known else effect.initial_state(seen)
        for slot, effect in zip(slots, acting, strict=True)
    ]
    position, velocity, control = batch.bind("qpos"), batch.bind("qvel"), batch.bind("ctrl")
    q = np.empty((rows, steps, position.shape[1]))
    v = np.empty((rows, steps, velocity.shape[1]))
    for step in range(steps):
        control[:] = command[:, step]
        seen.act(acting, states)
        batch.step()
        q[:, step], v[:, step] = position, velocity
    return q, v
