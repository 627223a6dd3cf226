"""What limits of an actuator's torque have in common: how they show along a recording."""

from __future__ import annotations

from abc import abstractmethod
from typing import TypeVar

import numpy as np

from morph.arrays import Array
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion

Some = TypeVar("Some", bound="LimitEffect")


class LimitEffect(ActuatorEffect):
    """An effect that cuts an actuator's torque off.

    What it cuts off is not in proportion to its parameters: its one column is the force at
    the limit as it stands, and its coefficient is one. A fit of that coefficient tells how
    well the limit fits.
    """

    @abstractmethod
    def limits(self, speed: Array) -> tuple[Array, Array]:
        """Return the least and the greatest torque at a joint's speeds, shape (...,)."""

    def regressor(self, motion: Motion) -> Array:
        """Return what is cut off."""
        effort = motion.effort(self.actuator)
        low, high = self.limits(motion.drive_speed(self.actuator))
        return motion.actuated(self.actuator, np.clip(effort, low, high) - effort)

    @property
    def coefficients(self) -> Array:
        """One."""
        return np.ones(1)

    def with_strengths(self: Some, coefficients: Array) -> Some:
        """Return the limit as it stands, or none where a fit wants the opposite."""
        return self if float(coefficients[0]) > 0.0 else self.neutral()
