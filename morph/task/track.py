"""Track: a point of the body is where a course has come by now."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.limbs import torso_of
from morph.body.robot import Robot
from morph.task.moved import Moved
from morph.task.quantity import Point, Quantity
from morph.task.reach import reach
from morph.task.swim import swim
from morph.task.task import Task
from morph.task.term import Goal, Term
from morph.task.torso import origin_of

RADIUS, TURN = 0.03, 4.0
"""Radius, m, and period, s, of the circle that the end of an arm follows."""

SPEED = 0.05
"""Speed at which a swimmer follows a straight course, m/s."""


@dataclass(frozen=True, kw_only=True)
class Course(Quantity):
    """How far a point of a link is from a course that moves on, m.

    At time t the course is at begin + velocity t + radius (cos(w t) - 1, sin(w t)), w = 2 pi
    / turn, the circle in the plane of y and z: so it begins at `begin`.
    """

    name: ClassVar[str] = "distance from a course"

    link: str
    """The link."""
    begin: tuple[float, float, float]
    """Where the course begins, m."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The point in the link's frame, m."""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """How fast the course moves on, m/s."""
    radius: float = 0.0
    """Radius of its circle, m; 0 for none."""
    turn: float = 1.0
    """Time of one round, s."""
    axes: str = "xyz"
    """Axes of the world that count."""

    def size(self, robot: Robot) -> int:
        """Return how many axes count."""
        return self._point.size(robot)

    @property
    def _point(self) -> Point:
        return Point(link=self.link, offset=self.offset, axes=self.axes)

    def at(self, time: Array) -> Array:
        """Return where the course is at each time, s, m, shape (times, 3)."""
        angle = 2.0 * math.pi * time / self.turn
        course = np.array(self.begin) + np.outer(time, self.velocity)
        course[:, 1] += self.radius * (np.cos(angle) - 1.0)
        course[:, 2] += self.radius * np.sin(angle)
        return np.asarray(course)

    def value(self, moved: Moved) -> Array:
        """Return the point less the course, shape (..., samples, axes)."""
        course = self.at(moved.time)[:, ["xyz".index(axis) for axis in self.axes]]
        return np.asarray(self._point.value(moved) - course)


def track(robot: Robot) -> Task:
    """Return the task to follow a course: the end of an arm a circle, a swimmer a line.

    An arm has 2 s to come to the circle, of 3 cm and 4 s, and goes round it once within 2 cm.
    A swimmer follows a point that moves ahead at 0.05 m/s, within 0.3 m, for 20 s.

    Raises:
        TaskError: The body can neither reach nor swim.
    """
    link = torso_of(robot)
    if link is None:
        return _arm(robot)
    task = swim(robot)
    x, y, z = (float(each) for each in origin_of(robot, link, {}))
    course = Course(link=link, begin=(x, y, z), velocity=(SPEED, 0.0, 0.0), axes="xy")
    return _following(task, course, within=0.3, last=task.horizon)


def _arm(robot: Robot) -> Task:
    task = replace(reach(robot), horizon=2.0 + TURN)
    end = task.goals[0].quantity
    if not isinstance(end, Point):
        return task
    x, y, z = task.goals[0].target
    course = Course(link=end.link, offset=end.offset, begin=(x, y, z), radius=RADIUS, turn=TURN)
    return _following(task, course, within=0.02, last=TURN)


def _following(task: Task, course: Course, *, within: float, last: float) -> Task:
    zero = (0.0,) * len(course.axes)
    term = Term(
        name="off course",
        quantity=course,
        target=zero,
        width=2.0 * within,
        weight=task.period,
        norm="saturating",
    )
    goal = Goal(name="on course", quantity=course, target=zero, within=within, last=last)
    kept = tuple(each for each in task.terms if each.name.startswith(("effort", "speed")))
    return replace(task, name="track", terms=(term, *kept), goals=(goal,))
