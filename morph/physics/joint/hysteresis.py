"""A force that lags behind the displacement of a joint at every speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Simulations, parameter
from morph.physics.joint.recorded import followed_hysteresis
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion
from morph.physics.stacked import stacked

SPANS = (0.01, 0.03, 0.1, 0.3)
"""Displacements z to try, as shares of the joint's range in a recording."""


@dataclass(frozen=True, kw_only=True)
class Hysteresis(JointEffect):
    """A spring that yields: tau = -c h, z dh/dt = v - (abs(v) h + v abs(h)) / 2, abs(h) <= 1.

    Bouc and Wen's loop with exponent 1 and equal shares for loading and unloading. It is
    stiff, c / z, where the joint turns back, and holds c where the joint has gone far. It
    depends on the path, not on the speed. A run starts with h = 0.

    Source: Wen 1976, J. Engineering Mechanics Division ASCE 102(2), scaled as in Ismail,
    Ikhouane and Rodellar 2009, Arch. Computational Methods in Engineering 16. Between two
    steps it is solved exactly.
    """

    name: ClassVar[str] = "hysteresis"
    strengths: ClassVar[tuple[str, ...]] = ("c",)
    suspected: ClassVar[bool] = False
    simpler: ClassVar[str] = "coulomb_friction"
    twins: ClassVar[tuple[str, ...]] = ("backlash", "stribeck_friction")
    excited_by: ClassVar[str] = "Small reversals beside large ones, slowly and fast."
    separate_by: ClassVar[dict[str, str]] = {
        "backlash": "Small reversals of the command about a loaded rest: hysteresis gives at once, "
        "play gives freely once the load changes its sign.",
        "stribeck_friction": "The same reversals at two speeds: a loop of hysteresis stays as it "
        "is.",
        "coulomb_friction": "Small reversals from rest: what sticks does not move, hysteresis "
        "springs back.",
    }

    joint: str
    """Joint it acts on."""
    c: float = parameter(0.0, unit="N m", low=0.0, high=1e4, neutral=0.0)
    """Force that the loop comes to (N on a slide)."""
    z: float = parameter(0.05, unit="rad", low=1e-5, high=100.0)
    """Displacement over which it builds up to 1 - 1/e of that (m on a slide)."""

    def initial_state(self, simulations: Simulations) -> Any:
        """Return the position and h, nothing yet."""
        here = simulations.position(self.joint).copy()
        return here, np.zeros_like(here)

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Follow the joint, and push back."""
        before, held = state
        here = simulations.position(self.joint).copy()
        held = followed(held, (here - before) / self.z)
        simulations.force(self.joint)[:] -= self.c * held
        return here, held

    def regressor(self, motion: Motion) -> Array:
        """Return minus h along the recorded positions."""
        held = followed_hysteresis(motion.place(self.joint), np.atleast_1d(self.z))
        return motion.along(self.joint, *-held.T)

    @classmethod
    def regressors(cls, shapes: Sequence[Hysteresis], motion: Motion) -> Array:
        """Return the regressors of several displacements z, followed together."""
        return stacked(shapes).regressor(motion)

    def shapes(self, motion: Motion) -> tuple[Hysteresis, ...]:
        """Return the loop with a few displacements z between fine and coarse."""
        span = float(np.ptp(motion.place(self.joint)))
        return tuple(replace(self, z=float(np.clip(s * span, 1e-5, 100.0))) for s in SPANS)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, length = ("N", "m") if slide else ("N m", "rad")
        return (
            f"Joint {self.joint} holds back {self.c:.3g} {force}, built up over about "
            f"{self.z:.3g} {length} after each reversal at any speed: hysteresis was left out."
        )


def followed(held: Array, move: Array) -> Array:
    """Return h after a move of that many z; any shape.

    With y = h in the direction of the move: dy/dx = 1 while y < 0, and 1 - y from there.
    """
    sense, way = np.sign(move), np.abs(move)
    ahead = sense * held
    left = way + np.minimum(ahead, 0.0)
    loaded = 1.0 - (1.0 - np.maximum(ahead, 0.0)) * np.exp(-np.maximum(left, 0.0))
    return np.asarray(np.where(way > 0.0, sense * np.where(left > 0.0, loaded, left), held))
