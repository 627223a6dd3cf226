"""An actuator that does nothing on small commands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import UNLIMITED, Simulations, parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion

SHARES = (0.01, 0.03, 0.06, 0.1, 0.2, 0.3)
"""Thresholds to try, as shares of the greatest torque along a recording."""


@dataclass(frozen=True, kw_only=True)
class DeadZone(ActuatorEffect):
    """Torque up to a threshold d is lost: tau = u - clip(u, -d, d).

    u is what the actuator would produce, at the joint: for a motor this is its command in
    units of torque, for a servo its error.

    Source: Khalil 2002, Nonlinear Systems, section 1.2.7 (dead zone).
    """

    name: ClassVar[str] = "dead_zone"
    strengths: ClassVar[tuple[str, ...]] = ("threshold",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("coulomb_friction", "backlash")
    excited_by: ClassVar[str] = "Small commands of both signs, from rest and in motion."
    separate_by: ClassVar[dict[str, str]] = {
        "coulomb_friction": "A start from rest under a slowly growing command, and free swinging "
        "with no command.",
        "backlash": "Small commands about a loaded rest: a dead zone is felt under load too.",
        "stribeck_friction": "Free swinging with no command: a dead zone takes nothing there.",
    }

    actuator: str
    """Actuator it acts on."""
    threshold: float = parameter(0.0, unit="N m", low=0.0, high=UNLIMITED, neutral=0.0)
    """Torque that is lost, at the joint (N on a slide)."""

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Take off what is below the threshold."""
        effort = simulations.effort(self.actuator)
        effort[:] -= np.clip(effort, -self.threshold, self.threshold)
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return minus the torque over the threshold, at most one; for none minus its sign."""
        effort = motion.effort(self.actuator)
        if self.threshold > 0.0:
            return motion.actuated(self.actuator, -np.clip(effort / self.threshold, -1.0, 1.0))
        return motion.actuated(self.actuator, -np.sign(effort))

    def shapes(self, motion: Motion) -> tuple[DeadZone, ...]:
        """Return thresholds at a few shares of the greatest torque that was recorded."""
        most = float(np.abs(motion.effort(self.actuator)).max())
        return tuple(replace(self, threshold=min(share * most, UNLIMITED)) for share in SHARES)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Actuator {self.actuator} loses the first {self.threshold:.3g} "
            f"{'N' if slide else 'N m'} of what it is told in either direction: a dead zone was "
            "left out."
        )
