"""A motor that brakes itself while it is powered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import Simulations, parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class BackEmf(ActuatorEffect):
    """A motor's torque falls with its speed while it is powered: tau = u - k v.

    It is powered while its command is not exactly 0; with its terminals open it turns
    freely. k is the product of the torque and voltage constants over the resistance, behind
    the gear. Read before each step: it needs a step below 2 inertia / k.

    Source: Spong, Hutchinson and Vidyasagar 2006, Robot Modeling and Control,
    section 6.2.
    """

    name: ClassVar[str] = "back_emf"
    strengths: ClassVar[tuple[str, ...]] = ("k",)
    dissipative: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("viscous_friction", "speed_torque_limit")
    excited_by: ClassVar[str] = "Motion at two speeds with a command, and coasting without one."
    separate_by: ClassVar[dict[str, str]] = {
        "viscous_friction": "Coast without a command from full speed: only friction brakes then.",
        "speed_torque_limit": "Small commands at full speed: a limit does not touch them.",
        "torque_saturation": "The greatest command with the link held, and again at full speed.",
        "linear_drag": "Coast without a command from full speed: only drag brakes then.",
    }

    actuator: str
    """Actuator it acts on."""
    k: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e5, neutral=0.0)
    """Torque lost per unit of speed (N s/m on a slide)."""

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the actuators whose joint has a speed."""
        return cls.jointed(robot)

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Brake the joint while there is a command."""
        speed = simulations.drive_speed(self.actuator)
        powered = simulations.control(self.actuator) != 0.0
        simulations.effort(self.actuator)[:] -= np.where(powered, self.k * speed, 0.0)
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return minus the speed while there is a command."""
        powered = motion.command[:, motion.actuators[self.actuator]] != 0.0
        speed = motion.drive_speed(self.actuator)
        return motion.actuated(self.actuator, -speed * powered)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, speed = ("N", "m/s") if slide else ("N m", "rad/s")
        return (
            f"Actuator {self.actuator} gives {self.k:.3g} {force} less for each {speed} of speed "
            "while it is powered: the voltage that the motor itself induces was left out."
        )
