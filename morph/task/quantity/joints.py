"""Quantities of joints: where they stand and how fast they move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Joint, Robot
from morph.errors import RobotError
from morph.task.moved import Moved
from morph.task.quantity.quantity import Quantity, wrapped


@dataclass(frozen=True, kw_only=True)
class JointPositions(Quantity):
    """Positions of hinges, rad, and slides, m; the error of a hinge knows no full turns."""

    name: ClassVar[str] = "joint positions"

    joints: tuple[str, ...]
    """The joints, by name."""

    def size(self, robot: Robot) -> int:
        """Return how many joints it names."""
        return len(single(robot, self.joints))

    def value(self, moved: Moved) -> Array:
        """Return the positions, shape (..., samples, joints)."""
        return np.stack([moved.joint(name) for name in self.joints], axis=-1)

    def error(self, moved: Moved, target: tuple[float, ...]) -> Array:
        """Return positions less the target, hinges the shorter way round."""
        error = super().error(moved, target)
        turning = [moved.robot.joint(name).kind == "hinge" for name in self.joints]
        return np.where(turning, wrapped(error), error)


@dataclass(frozen=True, kw_only=True)
class JointSpeeds(Quantity):
    """Velocities of hinges, rad/s, and slides, m/s."""

    name: ClassVar[str] = "joint speeds"

    joints: tuple[str, ...]
    """The joints, by name."""

    def size(self, robot: Robot) -> int:
        """Return how many joints it names."""
        return len(single(robot, self.joints))

    def value(self, moved: Moved) -> Array:
        """Return the velocities, shape (..., samples, joints)."""
        return np.stack([moved.speed(name) for name in self.joints], axis=-1)


@dataclass(frozen=True, kw_only=True)
class AngleSum(Quantity):
    """Sum of the angles of hinges, rad: how a link at the end of a planar chain stands."""

    name: ClassVar[str] = "sum of angles"

    joints: tuple[str, ...]
    """The hinges from the root to the link."""

    def size(self, robot: Robot) -> int:
        """Return 1."""
        single(robot, self.joints)
        return 1

    def value(self, moved: Moved) -> Array:
        """Return the sum, shape (..., samples, 1)."""
        return np.asarray(sum(moved.joint(name) for name in self.joints))[..., None]

    def error(self, moved: Moved, target: tuple[float, ...]) -> Array:
        """Return the sum less the target, the shorter way round."""
        return wrapped(super().error(moved, target))


def single(robot: Robot, names: tuple[str, ...]) -> tuple[Joint, ...]:
    """Return joints of one freedom each by their names.

    Raises:
        RobotError: There is no such joint, or it has more freedoms than one.
    """
    joints = tuple(robot.joint(name) for name in names)
    for joint in joints:
        if joint.kind not in {"hinge", "slide"}:
            raise RobotError(
                f"the {joint.kind} joint {joint.name!r} has no single position",
                where=f"robot {robot.name}",
                fix="name hinges and slides; of a body that floats name its link",
            )
    return joints
