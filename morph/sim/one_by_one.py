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
    models: Sequence[Any], position: Array, velocity: Array, command: Array
) -> tuple[Array, Array]:
    """Return positions and velocities of simulations whose fluid runs in numpy.

    The batch refuses functions written in Python, and the numpy fluid is one.

    Args:
        models: A `mujoco.MjModel` for each row.
        position: Where each row starts, shape (rows, nq).
        velocity: How fast, shape (rows, nv).
        command: Controls, constant over each step, shape (rows, steps, nu).

    Returns:
        Positions (rows, steps + 1, nq) and velocities (rows, steps + 1, nv).

    Raises:
        SimulationFailed: A row became unstable.
    """
    rows, steps = command.shape[:2]
    q = np.empty((rows, steps + 1, position.shape[1]))
    v = np.empty((rows, steps + 1, velocity.shape[1]))
    for row, model in enumerate(models):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = position[row], velocity[row]
        q[row, 0], v[row, 0] = position[row], velocity[row]
        with flowing(model):
            for step in range(steps):
                data.ctrl[:] = command[row, step]
                mujoco.mj_step(model, data)
                q[row, step + 1], v[row, step + 1] = data.qpos, data.qvel
        if any(data.warning[kind.value].number for kind in BAD):
            raise SimulationFailed(
                "the simulation became unstable",
                where=f"{steps} steps of {model.opt.timestep:g} s",
                fix="take a smaller step, or check masses, starts, commands and effects",
            )
    return q, v
