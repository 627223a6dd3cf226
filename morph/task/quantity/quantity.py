"""The family of quantities: what a task may ask of a body."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.task.moved import Moved


@dataclass(frozen=True, kw_only=True)
class Quantity(ABC):
    """Numbers of a body at each control time, which a term or a goal holds against a target."""

    name: ClassVar[str]
    """What it is called in files and messages."""

    @abstractmethod
    def value(self, moved: Moved) -> Array:
        """Return its numbers, shape (..., samples, size)."""

    @abstractmethod
    def size(self, robot: Robot) -> int:
        """Return how many numbers it has.

        Raises:
            RobotError: The body lacks a part that it names.
        """

    def error(self, moved: Moved, target: tuple[float, ...]) -> Array:
        """Return how far its numbers are from a target, shape (..., samples, size)."""
        return np.asarray(self.value(moved) - np.asarray(target, dtype=float))


def wrapped(angle: Array) -> Array:
    """Return angles, rad, within -pi (included) and pi."""
    return np.asarray((angle + math.pi) % (2.0 * math.pi) - math.pi)
