"""Quantities of links: where a point of one is, and which way one faces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import RobotError
from morph.task.moved import Moved
from morph.task.quantity.quantity import Quantity


@dataclass(frozen=True, kw_only=True)
class Point(Quantity):
    """Where a point of a link is in the world, m; of the axes that are asked for."""

    name: ClassVar[str] = "point"

    link: str
    """The link."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The point in the link's frame, m."""
    axes: str = "xyz"
    """Axes of the world: `xyz`, `xz`, `z` and so on."""

    def size(self, robot: Robot) -> int:
        """Return how many axes it has."""
        robot.link(self.link)
        if not self.axes or set(self.axes) - set("xyz") or len(set(self.axes)) != len(self.axes):
            raise RobotError(
                f"its axes are {self.axes!r}",
                where=f"a point of link {self.link}",
                fix="give each of x, y and z once or not at all",
            )
        return len(self.axes)

    def value(self, moved: Moved) -> Array:
        """Return the coordinates, shape (..., samples, axes)."""
        body = moved.model.body(self.link).id
        pose = moved.pose(body)
        where = pose.position + pose.rotation @ np.array(self.offset)
        return np.asarray(where[..., ["xyz".index(axis) for axis in self.axes]])


@dataclass(frozen=True, kw_only=True)
class Direction(Quantity):
    """Where an axis of a link points in the world: a vector of length 1."""

    name: ClassVar[str] = "direction"

    link: str
    """The link."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """The axis in the link's frame, of length 1."""

    def size(self, robot: Robot) -> int:
        """Return 3."""
        robot.link(self.link)
        return 3

    def value(self, moved: Moved) -> Array:
        """Return the vector in the world, shape (..., samples, 3)."""
        body = moved.model.body(self.link).id
        return np.asarray(moved.pose(body).rotation @ np.array(self.axis))


@dataclass(frozen=True, kw_only=True)
class FloatSpeed(Quantity):
    """Velocity of a body that floats: linear in the world, m/s, or angular in its frame, rad/s."""

    name: ClassVar[str] = "velocity of a floating body"

    link: str
    """The link with the free joint."""
    angular: bool = False
    """Whether it is the angular velocity."""

    def size(self, robot: Robot) -> int:
        """Return 3."""
        free_joint(robot, self.link)
        return 3

    def value(self, moved: Moved) -> Array:
        """Return the velocity, shape (..., samples, 3)."""
        first = int(moved.model.joint(free_joint(moved.robot, self.link)).dofadr[0])
        first += 3 if self.angular else 0
        return np.asarray(moved.velocity[..., first : first + 3])


def free_joint(robot: Robot, link: str) -> str:
    """Return the name of the free joint of a link.

    Raises:
        RobotError: There is no such link, or it does not float.
    """
    robot.link(link)
    for joint in robot.joints:
        if joint.kind == "free" and joint.link == link:
            return joint.name
    raise RobotError(
        f"link {link!r} has no free joint",
        where=f"robot {robot.name}",
        fix="name the link of a body that floats",
    )
