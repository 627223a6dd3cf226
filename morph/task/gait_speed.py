"""Gait speed: go ahead at a given speed, on a floor or in water."""

from __future__ import annotations

from dataclasses import replace

from morph.body.robot import Robot
from morph.errors import TaskError
from morph.task.quantity import Point
from morph.task.swim import swim
from morph.task.task import Task
from morph.task.term import Goal, Term
from morph.task.torso import origin_of, torso
from morph.task.walk import walk

SHARE = 0.1
"""Farthest that the distance at the end may be off, in distances that were asked for."""


def gait_speed(robot: Robot, *, speed: float = 0.1, horizon: float = 10.0) -> Task:
    """Return the task to go ahead at a speed on average, neither slower nor faster.

    A body whose card knows water does it in water, any other on a floor.

    Args:
        robot: The body.
        speed: Along x, the way it faces, m/s.
        horizon: For how long, s.

    Raises:
        TaskError: The body is held to the world, has no actuator, or the speed is none.
    """
    name = "gait-speed"
    if not 0.0 < speed <= 10.0:
        raise TaskError(
            f"a speed of {speed:g} m/s is out of range, above 0 to 10",
            where=f"task {name} of {robot.name}",
            fix="take 0.1 m/s",
        )
    link = torso(robot, name)
    wet = robot.card is not None and robot.card.water is not None
    distance = speed * horizon
    task = (swim if wet else walk)(robot, distance=distance, horizon=horizon)
    x = float(origin_of(robot, link, task.start.position)[0])
    forward = Point(link=link, axes="x")
    term = Term(
        name="forward",
        quantity=forward,
        target=(x + distance,),
        width=SHARE * distance,
        last_only=True,
    )
    goal = Goal(name="forward", quantity=forward, target=(x + distance,), within=SHARE * distance)
    return replace(
        task,
        name=name,
        terms=(term, *(each for each in task.terms if each.name != term.name)),
        goals=(goal, *(each for each in task.goals if each.name != goal.name)),
    )
