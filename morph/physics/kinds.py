"""The kinds of part that an effect acts on: joint, actuator, sensor, body, contact, world."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from morph.body.robot import Robot
from morph.errors import EffectError
from morph.physics.effect import Effect
from morph.physics.motion import Motion

Some = TypeVar("Some", bound=Effect)


class JointEffect(Effect):
    """An effect on one hinge or slide."""

    kind = "joint"
    joint: str

    @property
    def where(self) -> str:
        """The joint."""
        return self.joint

    @classmethod
    def at(cls: type[Some], where: str) -> Some:
        """Return the effect at a joint."""
        return cls(joint=where)  # type: ignore[call-arg]

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the hinges and slides."""
        return tuple(j.name for j in robot.joints if j.kind in {"hinge", "slide"})

    def extent(self, motion: Motion) -> float:
        """Return the range of the joint's positions."""
        return float(np.ptp(motion.place(self.joint)))

    def restarts(self: Some, motions: Sequence[Motion]) -> tuple[Some, ...]:
        """Return the effect where a refit that ended here may begin anew; by default nowhere."""
        return ()


class ActuatorEffect(Effect):
    """An effect on one actuator."""

    kind = "actuator"
    actuator: str

    @property
    def where(self) -> str:
        """The actuator."""
        return self.actuator

    @classmethod
    def at(cls: type[Some], where: str) -> Some:
        """Return the effect at an actuator."""
        return cls(actuator=where)  # type: ignore[call-arg]

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the actuators."""
        return tuple(actuator.name for actuator in robot.actuators)

    @classmethod
    def jointed(cls, robot: Robot) -> tuple[str, ...]:
        """Return the actuators that drive a hinge or slide."""
        return tuple(actuator.name for actuator in robot.actuators if actuator.joint)

    def extent(self, motion: Motion) -> float:
        """Return the greatest of what the actuator produces."""
        return float(np.abs(motion.effort(self.actuator)).max())


class SensorEffect(Effect):
    """An effect on one channel."""

    kind = "sensor"
    channel: str

    @property
    def where(self) -> str:
        """The channel."""
        return self.channel

    @classmethod
    def at(cls: type[Some], where: str) -> Some:
        """Return the effect at a channel."""
        return cls(channel=where)  # type: ignore[call-arg]

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the position channels of the hinges and slides."""
        names = (j.name for j in robot.joints if j.kind in {"hinge", "slide"})
        return tuple(f"{name}.position" for name in names)

    @classmethod
    def measured(cls, robot: Robot) -> tuple[str, ...]:
        """Return the position and velocity channels of the hinges and slides."""
        names = [j.name for j in robot.joints if j.kind in {"hinge", "slide"}]
        return tuple(f"{n}.{what}" for n in names for what in ("position", "velocity"))


class BodyEffect(Effect):
    """An effect on one link."""

    kind = "body"
    body: str

    @property
    def where(self) -> str:
        """The link."""
        return self.body

    @classmethod
    def at(cls: type[Some], where: str) -> Some:
        """Return the effect at a link."""
        return cls(body=where)  # type: ignore[call-arg]

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the links that can move."""
        return tuple(link.name for link in robot.links)


class ContactEffect(Effect):
    """An effect where two bodies touch, named `foot+floor`; `any+floor` is every link's."""

    kind = "contact"
    contact: str

    @property
    def where(self) -> str:
        """The two bodies, joined by a plus sign."""
        return self.contact

    @classmethod
    def at(cls: type[Some], where: str) -> Some:
        """Return the effect between two bodies."""
        return cls(contact=where)  # type: ignore[call-arg]

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return `any+floor`, each link with the floor, and each pair of links, either first."""
        names = [link.name for link in robot.links]
        pairs = (f"{one}+{two}" for one, two in itertools.permutations(names, 2))
        floor = (f"{name}+floor" for name in ("any", *names))
        return (*floor, *pairs, *(f"floor+{name}" for name in ("any", *names)))

    @classmethod
    def suspects(cls, robot: Robot) -> tuple[str, ...]:
        """Return nothing: a recording of motion does not hold what presses."""
        return ()


class WorldEffect(Effect):
    """An effect of what surrounds every body."""

    kind = "world"

    @property
    def where(self) -> str:
        """Always `world`."""
        return "world"

    @classmethod
    def at(cls: type[Some], where: str = "world") -> Some:
        """Return the effect on the world.

        Raises:
            EffectError: It is to act elsewhere.
        """
        if where != "world":
            raise EffectError(
                f"{cls.name} acts on the world, not on {where!r}",
                where=f"effect {cls.name}@{where}",
                fix=f"say {cls.name}@world",
            )
        return cls()

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return `world`."""
        return ("world",)

    @classmethod
    def suspects(cls, robot: Robot) -> tuple[str, ...]:
        """Return nothing: none of the world's effects so far is screened from motion alone."""
        return ()
