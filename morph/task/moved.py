"""What a body did, as the terms of a task see it: many runs at once."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch

from morph.arrays import Array, Mask
from morph.body.robot import Robot
from morph.sim.threads import batch_threads

MOST_AT_ONCE = 8192
"""States whose links are placed at once; more would leave the processor's cache."""


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where the links are, by MuJoCo's number of the body."""

    position: Array
    """Origins of the links in the world, m, shape (..., bodies, 3)."""
    rotation: Array
    """Axes of the links in the world, as columns, shape (..., bodies, 3, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moved:
    """States and commands of many runs at the control times."""

    robot: Robot
    """The body."""
    model: Any
    """Its compiled `mujoco.MjModel`."""
    time: Array
    """The control times, s, shape (samples,)."""
    position: Array
    """MuJoCo's `qpos`, shape (..., samples, nq)."""
    velocity: Array
    """MuJoCo's `qvel`, shape (..., samples, nv)."""
    command: Array
    """What is commanded from each time on, shape (..., samples, nu); the last is held."""
    stable: Mask | None = None
    """Which runs stayed stable, shape (...,); None if all did."""

    def joint(self, name: str) -> Array:
        """Return the position of a hinge, rad, or a slide, m, shape (..., samples)."""
        return np.asarray(self.position[..., self.model.joint(name).qposadr[0]])

    def speed(self, name: str) -> Array:
        """Return the velocity of a hinge or a slide, per s, shape (..., samples)."""
        return np.asarray(self.velocity[..., self.model.joint(name).dofadr[0]])

    @cached_property
    def places(self) -> Places:
        """Where every link is at every time; nowhere (nan) where a position is no number."""
        shape = self.position.shape[:-1]
        rows = self.position.reshape(-1, self.position.shape[-1])
        # MuJoCo would take the description's own positions instead, without a word.
        lost = np.asarray(~np.isfinite(rows).all(axis=-1))
        rows = np.where(lost[:, None], self.model.qpos0, rows)
        position = np.empty((len(rows), self.model.nbody, 3))
        rotation = np.empty((len(rows), self.model.nbody, 9))
        size = min(len(rows), MOST_AT_ONCE)
        # Where links are asks for no contact, and finding contacts takes most of the time.
        model = copy.copy(self.model)
        for part in (mujoco.mjtDisableBit.mjDSBL_CONTACT, mujoco.mjtDisableBit.mjDSBL_CONSTRAINT):
            model.opt.disableflags |= int(part)
        batch = Batch(model, size, batch_threads(size))
        batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        q, x, R = batch.bind("qpos"), batch.bind("xpos"), batch.bind("xmat")
        for first in range(0, len(rows), size):
            here = rows[first : first + size]
            q[: len(here)] = here
            batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
            position[first : first + size] = x[: len(here)]
            rotation[first : first + size] = R[: len(here)].reshape(len(here), -1, 9)
        position[lost], rotation[lost] = np.nan, np.nan
        return Places(
            position=position.reshape(*shape, -1, 3),
            rotation=rotation.reshape(*shape, -1, 3, 3),
        )
