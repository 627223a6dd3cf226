"""Dry friction of one level at every speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class CoulombFriction(JointEffect):
    """A joint loses the same force at every speed, and holds at rest.

    tau = -c sign(v); at rest it takes any value up to c that keeps the joint still.

    Source: Coulomb 1785, Theorie des machines simples; set-valued form as in
    Stewart 2000, SIAM Review 42(1), eq. 2.
    """

    name: ClassVar[str] = "coulomb_friction"
    strengths: ClassVar[tuple[str, ...]] = ("c",)
    dissipative: ClassVar[bool] = True
    holds: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ("viscous_friction", "stribeck_friction", "dead_zone")
    excited_by: ClassVar[str] = "Slow motion, reversals, and one stop and start."
    separate_by: ClassVar[dict[str, str]] = {
        "viscous_friction": "Two constant speeds at least five times apart, and a stop and start.",
        "stribeck_friction": "Very slow motion in both directions, then a start from rest under a "
        "slowly growing command.",
        "dead_zone": "A start from rest under a slowly growing command, and free swinging with no "
        "command.",
    }

    joint: str
    """Joint it acts on."""
    c: float = parameter(0.0, unit="N m", low=0.0, high=1e4, neutral=0.0)
    """Friction's level (N on a slide)."""

    def edit(self, spec: Any) -> None:
        """Add to the joint's friction loss."""
        # A force cannot hold a joint still; MuJoCo's friction constraint can.
        spec.joint(self.joint).frictionloss += self.c

    def regressor(self, motion: Motion) -> Array:
        """Return minus the sense of motion."""
        return motion.along(self.joint, -motion.sign(self.joint))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Joint {self.joint} loses {self.c:.3g} {'N' if slide else 'N m'} against its motion "
            "at every speed: Coulomb friction was left out."
        )
