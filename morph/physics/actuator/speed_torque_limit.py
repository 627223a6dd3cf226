"""An actuator that gives less the faster it turns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.actuator.limit import LimitEffect
from morph.physics.effect import UNLIMITED, Simulations, Some, parameter
from morph.physics.motion import Motion

STALLS = (0.02, 0.05, 0.1, 0.2, 0.5, 0.8, 1.2, 2.0)
"""Stall torques to try, as shares of the greatest torque along a recording."""
RACES = (0.4, 0.7, 1.05, 1.4, 2.5)
"""No-load speeds to try, as shares of the greatest speed along a recording."""


@dataclass(frozen=True, kw_only=True)
class SpeedTorqueLimit(LimitEffect):
    """The torque that drives is at most tau0 (1 - v / v0), that which brakes at most tau0.

    Read before each step: it needs a step below 2 inertia v0 / tau0.

    Source: Krishnan 2001, Electric Motor Drives, chapter 2: the line from stall to no load of
    a direct-current motor at its greatest voltage.
    """

    name: ClassVar[str] = "speed_torque_limit"
    strengths: ClassVar[tuple[str, ...]] = ("tau0",)
    suspected: ClassVar[bool] = False
    simpler: ClassVar[str] = "torque_saturation"
    twins: ClassVar[tuple[str, ...]] = ("torque_saturation", "back_emf")
    excited_by: ClassVar[str] = "Great commands from rest up to the greatest speed."
    separate_by: ClassVar[dict[str, str]] = {
        "torque_saturation": "The greatest command with the link held, and again at full speed.",
        "back_emf": "Small commands at full speed: a limit does not touch them.",
        "viscous_friction": "Coast without a command from full speed: a limit takes nothing.",
    }

    actuator: str
    """Actuator it acts on."""
    tau0: float = parameter(UNLIMITED, unit="N m", low=1e-6, high=UNLIMITED, neutral=UNLIMITED)
    """Torque at stall (N on a slide); at its greatest value nothing is limited."""
    v0: float = parameter(10.0, unit="rad/s", low=1e-3, high=1e5)
    """Speed at which nothing is left to drive (m/s on a slide)."""

    def limits(self, speed: Array) -> tuple[Array, Array]:
        """Return the least and the greatest torque at each speed."""
        stall = np.where(np.asarray(self.tau0) >= UNLIMITED, np.inf, self.tau0)
        share = np.asarray(speed / self.v0)
        with np.errstate(invalid="ignore"):
            high, low = stall * np.clip(1.0 - share, 0, 1), -stall * np.clip(1.0 + share, 0, 1)
        free = np.isinf(stall)
        return np.where(free, -np.inf, low), np.where(free, np.inf, high)

    def simplified(self, law: Some) -> Some:
        """Return a limit at the torque at stall."""
        return replace(law, limit=self.tau0)  # type: ignore[type-var]

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the actuators whose joint has a speed."""
        return cls.jointed(robot)

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Cut off what the actuator cannot give at this speed."""
        effort = simulations.effort(self.actuator)
        speed = simulations.drive_speed(self.actuator)
        effort[:] = np.clip(effort, *self.limits(speed))
        return state

    def shapes(self, motion: Motion) -> tuple[SpeedTorqueLimit, ...]:
        """Return lines that cut something, from a few torques to a few speeds without load."""
        most = float(np.abs(motion.effort(self.actuator)).max()) + 1e-6
        fastest = float(np.abs(motion.drive_speed(self.actuator)).max()) + 1e-3
        stalls = [float(min(share * most, 0.99 * UNLIMITED)) for share in STALLS]
        races = [float(min(share * fastest, 1e5)) for share in RACES]
        lines = [replace(self, tau0=tau0, v0=v0) for tau0 in stalls for v0 in races]
        return tuple(line for line in lines if line.regressor(motion).any())

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, speed = ("N", "m/s") if slide else ("N m", "rad/s")
        return (
            f"Actuator {self.actuator} drives with at most {self.tau0:.3g} {force} at rest and "
            f"with less the faster it turns, with nothing from {self.v0:.3g} {speed} on: its limit "
            "of torque over speed was left out."
        )
