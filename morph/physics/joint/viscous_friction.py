"""Friction in proportion to speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ViscousFriction(JointEffect):
    """A joint loses force in proportion to its speed: tau = -b v.

    Source: Newton 1687, Principia II, section I; Featherstone 2008, section 3.6.
    """

    name: ClassVar[str] = "viscous_friction"
    strengths: ClassVar[tuple[str, ...]] = ("b",)
    dissipative: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ("back_emf", "linear_drag", "coulomb_friction")
    excited_by: ClassVar[str] = "Motion at two constant speeds at least five times apart."
    separate_by: ClassVar[dict[str, str]] = {
        "coulomb_friction": "Two constant speeds at least five times apart, and a stop and start.",
        "quadratic_damping": "Three constant speeds: slow, twice as fast, four times as fast.",
    }

    joint: str
    """Joint it acts on."""
    b: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e4, neutral=0.0)
    """Force lost per unit of speed (N s/m on a slide)."""

    def edit(self, spec: Any) -> None:
        """Add to the joint's linear damping."""
        damping = spec.joint(self.joint).damping.copy()
        damping[0] += self.b
        spec.joint(self.joint).damping = damping

    def regressor(self, motion: Motion) -> Array:
        """Return minus the speed."""
        return motion.along(self.joint, -motion.speed(self.joint))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, speed = ("N", "m/s") if slide else ("N m", "rad/s")
        return (
            f"Joint {self.joint} loses {self.b:.3g} {force} for each {speed} of speed: viscous "
            "friction was left out."
        )
