"""Ground that is not level."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.contact.floor import floor_of
from morph.physics.effect import parameter
from morph.physics.kinds import WorldEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class GroundSlope(WorldEffect):
    """The floor leans: it is turned by roll about x, then by pitch about y.

    Its normal is (sin(pitch) cos(roll), -sin(roll), cos(pitch) cos(roll)); the floor turns
    about the point below the origin, at the height that `ground` gives it.

    Source: Craig 2005, Introduction to Robotics, eq. 2.64, with no turn about z.
    """

    name: ClassVar[str] = "ground_slope"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ("base_tilt",)
    excited_by: ClassVar[str] = "Standing, sliding or walking on the ground in two headings."
    separate_by: ClassVar[dict[str, str]] = {
        "base_tilt": "Let a part hang free above the ground: gravity's direction shows there.",
    }

    roll: float = parameter(0.0, unit="rad", low=-1.2, high=1.2, neutral=0.0)
    """Turn about the world's x axis."""
    pitch: float = parameter(0.0, unit="rad", low=-1.2, high=1.2, neutral=0.0)
    """Turn about the world's y axis; positive sinks towards +x."""

    def edit(self, spec: Any) -> None:
        """Turn the world's floor."""
        floor = floor_of(spec, f"effect {self.label}")
        if self.roll or self.pitch:
            a, b = 0.5 * self.roll, 0.5 * self.pitch
            # The product of the half turns about y and about x, w x y z.
            floor.quat = (
                math.cos(b) * math.cos(a),
                math.cos(b) * math.sin(a),
                math.sin(b) * math.cos(a),
                -math.sin(b) * math.sin(a),
            )

    def regressor(self, motion: Motion) -> Array:
        """Return no columns: what a floor pushes is not linear in its slope."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"The ground of the world leans by {self.roll:.3g} rad about x and "
            f"{self.pitch:.3g} rad about y: its slope was left out."
        )
