"""What several models predict together, each as far as it is probable."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.sim.tangent import apart, moved_by


@dataclass(frozen=True, kw_only=True, eq=False)
class Mixture:
    """What every model predicts, and what they predict together."""

    model: Any
    """A compiled `mujoco.MjModel` of the body."""
    probability: Array
    """Of each model, shape (models,)."""
    position: Array
    """`qpos` that each predicts, shape (models, samples, nq)."""
    velocity: Array
    """`qvel`, shape (models, samples, nv)."""

    @cached_property
    def mean(self) -> tuple[Array, Array]:
        """The mixture's mean: `qpos` (samples, nq) and `qvel` (samples, nv)."""
        origin = self.position[int(np.argmax(self.probability))]
        move = self._weighed(apart(self.model, self.position, origin))
        return moved_by(self.model, origin, move), self._weighed(self.velocity)

    @cached_property
    def spread(self) -> Array:
        """Standard deviation among models, of moves and then speeds, shape (samples, 2 nv)."""
        position, velocity = self.mean
        off = np.concatenate(
            [apart(self.model, self.position, position), self.velocity - velocity], axis=-1
        )
        return np.asarray(np.sqrt(self._weighed(off**2)))

    def _weighed(self, values: Array) -> Array:
        return np.asarray(np.einsum("k,k...->...", self.probability, values))
