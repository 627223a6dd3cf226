"""Simulations one after another in Python: what is left where `mujoco.batch` cannot run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.errors import SimulationFailed
from morph.physics.fluid.kernel import flowing

BAD = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)
"""MuJoCo's warnings that a simulation became unstable."""


def one_by_one(
    models: Sequence[Any], position: Array, velocity: Array, command: Array, *, strict: bool
) -> tuple[Array, Array]:
    """Return positions and velocities of simulations whose fluid runs in numpy.

    The batch refuses functions written in Python, and the numpy fluid is one.

    Args:
        models: A `mujoco.MjModel` for each row.
        position: Where each row starts, shape (rows, nq).
        velocity: How fast, shape (rows, nv).
        command: Controls, constant over each step, shape (rows, steps, nu).
        strict: Whether an unstable row is an error.

    Returns:
        Positions (rows, steps + 1, nq) and velocities (rows, steps + 1, nv). A row that
        became unstable repeats its last state.

    Raises:
        SimulationFailed: With `strict`, a row became unstable.
    """
    rows, steps = command.shape[:2]
    q = np.empty((rows, steps + 1, position.shape[1]))
    v = np.empty((rows, steps + 1, velocity.shape[1]))
    for row, model in enumerate(models):
        q[row, 0], v[row, 0] = position[row], velocity[row]
        with flowing(model):
            stable = _step(model, q[row], v[row], command[row])
        if strict and not stable:
            raise SimulationFailed(
                "the simulation became unstable",
                where=f"{steps} steps of {model.opt.timestep:g} s",
                fix="take a smaller step, or check masses, starts, commands and effects",
            )
    return q, v


def _step(model: Any, q: Array, v: Array, command: Array) -> bool:
    """Fill the states that follow the first, (steps + 1, n) each; return whether all are stable."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q[0], v[0]
    for step, commanded in enumerate(command):
        data.ctrl[:] = commanded
        mujoco.mj_step(model, data)
        if any(data.warning[kind.value].number for kind in BAD):
            q[step + 1 :], v[step + 1 :] = q[step], v[step]
            return False
        q[step + 1], v[step + 1] = data.qpos, data.qvel
    return True
