"""What an effect may see and touch of many simulations before each step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from morph.arrays import Array


class Simulations(Protocol):
    """Many simulations before a step; each array has one entry a simulation.

    What `force`, `effort`, `friction`, `armature` and `push` return is a view: what is
    written into it holds for the coming step alone. Effects of actuators act first, so
    that effects of joints find the effort that is left.
    """

    step: float
    """Seconds that the coming step lasts."""
    actuators: Mapping[str, str | None]
    """The joint that each actuator drives, by the actuator's name; None of one without a joint."""

    def position(self, joint: str) -> Array:
        """Return a joint's position, rad or m, shape (simulations,)."""

    def velocity(self, joint: str) -> Array:
        """Return a joint's velocity, per s, shape (simulations,)."""

    def force(self, joint: str) -> Array:
        """Return the view to which a joint's generalized forces are added."""

    def control(self, actuator: str) -> Array:
        """Return what an actuator receives for the step, in its own unit."""

    def drive_speed(self, actuator: str) -> Array:
        """Return the speed of an actuator's joint, per s, (simulations,); zero without one."""

    def effort(self, actuator: str) -> Array:
        """Return the view of what an actuator produces, at its joint if it drives one; N m or N.

        What an actuator without a joint produces can be scaled, and is none where it was none.
        """

    def torque(self, actuator: str, position: Array, velocity: Array) -> Array:
        """Return what an actuator would produce if its joint were there, N m or N."""

    def detach(self, actuator: str) -> None:
        """Take an actuator off its joint for good: only what `effort` is told is left."""

    def friction(self, joint: str) -> Array:
        """Return the view of the dry friction that a joint holds with, N m or N."""

    def armature(self, joint: str) -> Array:
        """Return the view of the inertia that turns with a joint, kg m2 or kg."""

    def push(self, body: str) -> Array:
        """Return the view of the force at a body's centre of mass, N, (simulations, 3).

        It is told along the axes of the world.
        """
