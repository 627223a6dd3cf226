"""The rotor's inertia seen through the gear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class Armature(JointEffect):
    """A rotor turns with a joint through a gear: tau = -J a, J rotor inertia times ratio squared.

    Source: Featherstone 2008, Rigid Body Dynamics Algorithms, section 9.6.
    """

    name: ClassVar[str] = "armature"
    strengths: ClassVar[tuple[str, ...]] = ("J",)
    twins: ClassVar[tuple[str, ...]] = ("link_inertia",)
    excited_by: ClassVar[str] = "Fast reversals of one joint at a time."
    separate_by: ClassVar[dict[str, str]] = {
        "torque_scale": "Rest under a constant command, beside fast reversals.",
    }

    joint: str
    """Joint it acts on."""
    J: float = parameter(0.0, unit="kg m2", low=0.0, high=1e4, neutral=0.0)
    """Inertia added to the joint (kg on a slide)."""

    def edit(self, spec: Any) -> None:
        """Add to the joint's armature."""
        spec.joint(self.joint).armature += self.J

    def regressor(self, motion: Motion) -> Array:
        """Return minus the acceleration."""
        return motion.along(self.joint, -motion.acceleration[:, motion.joints[self.joint]])

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Joint {self.joint} carries {self.J:.3g} {'kg' if slide else 'kg m2'} that turns with "
            "its motor: the rotor's inertia was left out."
        )
