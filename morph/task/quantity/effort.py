"""The quantity of commands: what a policy asks of the actuators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.task.moved import Moved
from morph.task.quantity.quantity import Quantity


@dataclass(frozen=True, kw_only=True)
class Commands(Quantity):
    """Commands of actuators in their units: N m, N, rad or m."""

    name: ClassVar[str] = "commands"

    actuators: tuple[str, ...]
    """The actuators, by name."""

    def size(self, robot: Robot) -> int:
        """Return how many actuators it names."""
        return len([robot.actuator(name) for name in self.actuators])

    def value(self, moved: Moved) -> Array:
        """Return the commands, shape (..., samples, actuators)."""
        return np.asarray(
            moved.command[..., [moved.model.actuator(name).id for name in self.actuators]]
        )
