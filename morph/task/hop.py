"""Hop: go a metre ahead on a floor, and on the way leave it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.task.moved import Moved
from morph.task.quantity import Quantity
from morph.task.task import Task
from morph.task.term import Goal
from morph.task.torso import feet_of, origin_of
from morph.task.walk import walk

LEAP = 0.03
"""How high every foot must have been lifted at one time, m."""


@dataclass(frozen=True, kw_only=True)
class Leap(Quantity):
    """How high the lowest of some links has been so far, m: all must leave the floor at once."""

    name: ClassVar[str] = "leap"

    links: tuple[str, ...]
    """The links, such as feet."""

    def size(self, robot: Robot) -> int:
        """Return 1."""
        for link in self.links:
            robot.link(link)
        return 1

    def value(self, moved: Moved) -> Array:
        """Return the greatest height so far of the lowest link's origin, (..., samples, 1)."""
        poses = [moved.pose(moved.model.body(link).id) for link in self.links]
        lowest = np.min([pose.position[..., 2] for pose in poses], axis=0)
        return np.asarray(np.maximum.accumulate(lowest, axis=-1))[..., None]


def hop(robot: Robot, *, distance: float = 1.0, horizon: float = 5.0) -> Task:
    """Return the task to hop so far along x: to be off the floor at least once, and never to fall.

    Raises:
        TaskError: The body is held to the world, or has no actuator.
    """
    task = walk(robot, distance=distance, horizon=horizon)
    feet = feet_of(robot)
    low = min(float(origin_of(robot, link, task.start.position)[2]) for link in feet)
    leap = Goal(name="leap", quantity=Leap(links=feet), target=(low + LEAP,), beyond=True)
    return replace(task, name="hop", goals=(*task.goals, leap))
