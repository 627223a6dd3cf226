"""Damping with the square of speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class QuadraticDamping(JointEffect):
    """A joint loses force with the square of its speed: tau = -b2 v abs(v).

    Source: Newton 1687, Principia II, section II; as polynomial damping in MuJoCo 4.
    """

    name: ClassVar[str] = "quadratic_damping"
    strengths: ClassVar[tuple[str, ...]] = ("b2",)
    dissipative: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ("viscous_friction", "quadratic_drag")
    excited_by: ClassVar[str] = "Fast motion beside slow motion of the same joint."
    separate_by: ClassVar[dict[str, str]] = {
        "viscous_friction": "Three constant speeds: slow, twice as fast, four times as fast.",
    }

    joint: str
    """Joint it acts on."""
    b2: float = parameter(0.0, unit="N m s2/rad2", low=0.0, high=1e4, neutral=0.0)
    """Force lost per unit of squared speed (N s2/m2 on a slide)."""

    def edit(self, spec: Any) -> None:
        """Add to the joint's quadratic damping."""
        damping = spec.joint(self.joint).damping.copy()
        damping[1] += self.b2
        spec.joint(self.joint).damping = damping

    def regressor(self, motion: Motion) -> Array:
        """Return minus the signed square of the speed."""
        speed = motion.speed(self.joint)
        return motion.along(self.joint, -speed * np.abs(speed))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, speed = ("N", "m/s") if slide else ("N m", "rad/s")
        return (
            f"Joint {self.joint} loses {self.b2:.3g} {force} at 1 {speed} and four times as much "
            f"at 2 {speed}: quadratic damping was left out."
        )
