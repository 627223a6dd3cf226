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
    """The hinges on the way from the root to the link."""
    signs: tuple[float, ...] = ()
    """1 for each hinge that turns as the first does, -1 for the others; empty if all do."""

    def size(self, robot: Robot) -> int:
        """Return 1.

        Raises:
            RobotError: There is no such joint, or there are more or fewer signs than joints.
        """
        single(robot, self.joints)
        if self.signs and len(self.signs) != len(self.joints):
            raise RobotError(
                f"it has {len(self.signs)} signs for {len(self.joints)} joints",
                where=f"a sum of angles of {robot.name}",
                fix="give one sign for each joint, or none",
            )
        return 1

    def value(self, moved: Moved) -> Array:
        """Return the sum, shape (..., samples, 1)."""
        signs = self.signs or (1.0,) * len(self.joints)
        each = [s * moved.joint(name) for s, name in zip(signs, self.joints, strict=True)]
        return np.asarray(sum(each))[..., None]

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
