"""A fluid that itself moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.fluid.numbers import CURRENT, add_numbers
from morph.physics.kinds import WorldEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class FluidCurrent(WorldEffect):
    """The fluid moves past the world, steadily and everywhere alike.

    Drag, added mass and thrust feel the velocity through the fluid, v - U.

    Source: Fossen 2011, Handbook of Marine Craft Hydrodynamics and Motion Control, section 8.3.
    """

    name: ClassVar[str] = "fluid_current"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ("sensor_bias", "base_tilt")
    excited_by: ClassVar[str] = "Motion with the current and against it, or rest in it."

    x: float = parameter(0.0, unit="m/s", low=-20.0, high=20.0, neutral=0.0)
    """Velocity along the world's x."""
    y: float = parameter(0.0, unit="m/s", low=-20.0, high=20.0, neutral=0.0)
    """Velocity along the world's y."""
    z: float = parameter(0.0, unit="m/s", low=-20.0, high=20.0, neutral=0.0)
    """Velocity along the world's z, up."""

    def edit(self, spec: Any) -> None:
        """Write the current into every body's numbers for the fluid."""
        for body in spec.bodies[1:]:
            add_numbers(spec, body.name, CURRENT, (self.x, self.y, self.z))

    def regressor(self, motion: Motion) -> Array:
        """Return no column: its force hangs on the drag of every link, and is not linear in it."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"The fluid of the world moves at {self.x:.3g}, {self.y:.3g}, {self.z:.3g} m/s: a "
            "current was left out."
        )
