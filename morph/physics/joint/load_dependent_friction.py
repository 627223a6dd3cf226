"""Dry friction that grows with the torque through the gear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Simulations, parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class LoadDependentFriction(JointEffect):
    """Dry friction grows with load: abs(tau) <= c0 + k abs(u), u what the actuators produce.

    The torque through the gear is taken to be that of the joint's actuators, before each
    step: exact for a gear without inertia of its own. The friction holds at rest.

    Source: Bittencourt and Gunnarsson 2012, J. Dyn. Sys. Meas. Control 134(5);
    set-valued form as in Stewart 2000, SIAM Review 42(1), eq. 2.
    """

    name: ClassVar[str] = "load_dependent_friction"
    strengths: ClassVar[tuple[str, ...]] = ("c0", "k")
    dissipative: ClassVar[bool] = True
    holds: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    simpler: ClassVar[str] = "coulomb_friction"
    twins: ClassVar[tuple[str, ...]] = ("coulomb_friction", "torque_scale")
    excited_by: ClassVar[str] = "Slow motion in both directions under small and under large loads."
    separate_by: ClassVar[dict[str, str]] = {
        "coulomb_friction": "The same slow motion with and without a weight at the end.",
        "torque_scale": "Raise and lower a weight slowly: friction acts against both, a wrong "
        "gain in one sense.",
    }

    joint: str
    """Joint it acts on."""
    c0: float = parameter(0.0, unit="N m", low=0.0, high=1e4, neutral=0.0)
    """Friction of the unloaded joint (N on a slide)."""
    k: float = parameter(0.0, unit="-", low=0.0, high=0.95, neutral=0.0)
    """Friction for each unit of what the actuators produce."""

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Let the joint hold and lose more under load."""
        driving = [a for a, joint in simulations.actuators.items() if joint == self.joint]
        load = sum((simulations.effort(actuator) for actuator in driving), np.float64(0.0))
        simulations.friction(self.joint)[:] += self.c0 + self.k * np.abs(load)
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return minus the sense of motion, alone and times the actuators' torque."""
        sign = motion.sign(self.joint)
        load = motion.drive[:, :, motion.joints[self.joint]].sum(axis=1)
        return motion.along(self.joint, -sign, -sign * np.abs(load))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Joint {self.joint} loses {self.c0:.3g} {'N' if slide else 'N m'} against its motion "
            f"and {100 * self.k:.3g} % of what its motor gives on top: friction that grows with "
            "load was left out."
        )
