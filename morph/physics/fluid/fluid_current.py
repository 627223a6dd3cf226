"""A fluid that itself moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.fluid.drag import Drag
from morph.physics.fluid.numbers import CURRENT, add_numbers
from morph.physics.kinds import WorldEffect
from morph.physics.motion import Motion

SLOW = 1e-4
"""Current of a finite difference, m/s: links move at 0.1 m/s and more."""


@dataclass(frozen=True, kw_only=True)
class FluidCurrent(WorldEffect):
    """The fluid moves past the world, steadily and everywhere alike.

    Drag, added mass and thrust feel the velocity through the fluid, v - U.

    Source: Fossen 2011, Handbook of Marine Craft Hydrodynamics and Motion Control, section 8.3.
    """

    name: ClassVar[str] = "fluid_current"
    strengths: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    suspected: ClassVar[bool] = False
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
        """Return no force: it acts `through` the drag of links."""
        return np.zeros((*motion.velocity.shape, 3))

    @staticmethod
    def through(drags: Sequence[Drag], motion: Motion) -> Array:
        """Return the change of links' drag by a current of one m/s along each axis of the world.

        To first order about fluid at rest, shape (samples, dofs, 3).
        """
        result = np.zeros((*motion.velocity.shape, 3))
        for drag in drags:
            body = motion.bodies[drag.body]
            still = drag.regressor(motion) @ drag.coefficients
            for axis in range(3):
                passing = np.zeros_like(body.velocity)
                passing[:, :3] = SLOW * body.axes[:, axis]
                seen = replace(body, velocity=body.velocity - passing)
                moved = replace(motion, bodies={drag.body: seen})
                force = drag.regressor(moved) @ drag.coefficients
                result[:, :, axis] += (force - still) / SLOW
        return result

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"The fluid of the world moves at {self.x:.3g}, {self.y:.3g}, {self.z:.3g} m/s: a "
            "current was left out."
        )
