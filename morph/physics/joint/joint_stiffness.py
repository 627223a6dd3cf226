"""A spring about a joint: a cable, a rubber cover, a real spring."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class JointStiffness(JointEffect):
    """A spring draws a joint to one position: tau = -k (q - q0).

    Source: Hooke 1678, De potentia restitutiva.
    """

    name: ClassVar[str] = "joint_stiffness"
    strengths: ClassVar[tuple[str, ...]] = ("k", "q0")
    twins: ClassVar[tuple[str, ...]] = ("com_offset",)
    excited_by: ClassVar[str] = "Rest or slow motion at positions far apart."
    separate_by: ClassVar[dict[str, str]] = {
        "sensor_bias": "Rest at three positions far apart.",
        "viscous_friction": "Rest at three positions far apart.",
    }

    joint: str
    """Joint it acts on."""
    k: float = parameter(0.0, unit="N m/rad", low=0.0, high=1e6, neutral=0.0)
    """Stiffness (N/m on a slide)."""
    q0: float = parameter(0.0, unit="rad", low=-6.5, high=6.5)
    """Position at which the spring is slack (m on a slide)."""

    def edit(self, spec: Any) -> None:
        """Join the spring to whatever spring the joint has already."""
        joint = spec.joint(self.joint)
        stiffness = joint.stiffness.copy()
        total = stiffness[0] + self.k
        if self.k > 0.0:
            joint.springref = (stiffness[0] * joint.springref + self.k * self.q0) / total
        stiffness[0] = total
        joint.stiffness = stiffness

    def regressor(self, motion: Motion) -> Array:
        """Return minus the position, and one: for k, and for k times q0."""
        position = motion.position[:, motion.joints[self.joint]]
        return motion.along(self.joint, -position, np.ones_like(position))

    @property
    def coefficients(self) -> Array:
        """k, and k times q0."""
        return np.array([self.k, self.k * self.q0])

    def with_strengths(self, coefficients: Array) -> JointStiffness:
        """Return the spring whose force is -coefficients[0] q + coefficients[1]."""
        k = float(np.clip(coefficients[0], 1e-6, 200.0))
        return replace(self, k=k, q0=float(np.clip(coefficients[1] / k, -3.2, 3.2)))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, length = ("N", "m") if slide else ("N m", "rad")
        return (
            f"Joint {self.joint} is drawn to {round(self.q0, 4):.3g} {length} by {self.k:.3g} "
            f"{force} per {length}: a spring or a cable was left out."
        )
