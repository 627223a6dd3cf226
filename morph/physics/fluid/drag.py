"""What linear and quadratic drag have in common: a law for each axis of a link."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.fluid.numbers import QUADRATIC, add_numbers
from morph.physics.fluid.wet import AXES, WetEffect, refer, shift
from morph.physics.motion import Motion


class Drag(WetEffect):
    """A resistance along and about each axis of a link, at the point (cx, cy, cz)."""

    strengths: ClassVar[tuple[str, ...]] = AXES
    dissipative: ClassVar[bool] = True
    slot: ClassVar[slice]
    """Where its six strengths stand among the link's numbers for the fluid."""

    @staticmethod
    @abstractmethod
    def law(speed: Array) -> Array:
        """Return the resistance to each component of a speed for a strength of one, same shape."""

    def edit(self, spec: Any) -> None:
        """Add to the link's numbers for the fluid."""
        strengths = [getattr(self, axis) for axis in AXES]
        if any(strengths):
            refer(spec, self.body, self.centre, self.label, quadratic=self.slot == QUADRATIC)
        add_numbers(spec, self.body, self.slot, strengths)

    def regressor(self, motion: Motion) -> Array:
        """Return the force of each axis for a drag of one."""
        body, moved = motion.bodies[self.body], shift(self.centre)
        speed = body.velocity @ moved.T
        return body.forces(np.einsum("ji,sj->sij", moved, -self.law(speed)))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        most = max(AXES, key=lambda axis: float(getattr(self, axis)))
        unit = next(known.unit for known in self.parameters() if known.name == most)
        return (
            f"Link {self.body} feels a drag of {getattr(self, most):.3g} {unit} "
            f"{'along' if most in 'xyz' else 'about'} its {most[-1]} axis: "
            "the drag of the fluid was left out."
        )
