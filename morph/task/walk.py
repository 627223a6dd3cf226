"""Walk: go a metre ahead on a floor without falling."""

from __future__ import annotations

from morph.body.postures import posture_of
from morph.body.robot import Robot
from morph.physics.worlds import world
from morph.task.quantity import Direction
from morph.task.stand import FLOOR, STEP, period_of, start_of
from morph.task.task import Task
from morph.task.term import Goal, Term
from morph.task.torso import torso
from morph.task.travel import travel_goals, travel_terms

FALLEN = 0.7
"""Farthest that any part of the torso's upright axis may ever be off, the sine of 45 degrees."""


def walk(robot: Robot, *, distance: float = 1.0, horizon: float = 10.0) -> Task:
    """Return the task to walk so far along x, the way a body faces, and never to fall.

    Raises:
        TaskError: The body is held to the world, or has no actuator.
    """
    name = "walk"
    link = torso(robot, name)
    start = posture_of(robot)
    period = period_of(robot)
    upright = Direction(link=link)
    # A fall costs more than any distance is worth; a trunk that sways costs next to nothing.
    fallen = Term(
        name="fall",
        quantity=upright,
        target=(0.0, 0.0, 1.0),
        width=FALLEN,
        weight=2.5 * period,
        norm="saturating",
    )
    return Task(
        name=name,
        robot=robot,
        terms=(*travel_terms(robot, link, start, distance), fallen),
        goals=(
            *travel_goals(robot, link, start, distance),
            Goal(
                name="not fallen",
                quantity=upright,
                target=(0.0, 0.0, 1.0),
                within=FALLEN,
                last=horizon,
            ),
        ),
        start=start_of(robot, start),
        horizon=horizon,
        period=period,
        step=STEP,
        world=FLOOR,
        effects=world(FLOOR, robot).effects,
    )
