"""Swim: go a metre ahead in water."""

from __future__ import annotations

from morph.body.robot import Robot
from morph.errors import TaskError
from morph.physics.worlds import WATERS, world
from morph.task.start import Start
from morph.task.task import Task
from morph.task.torso import torso
from morph.task.travel import travel_goals, travel_terms


def swim(
    robot: Robot, *, distance: float = 1.0, horizon: float = 20.0, water: str | None = None
) -> Task:
    """Return the task to swim so far along x, the way a body faces; it may roll and dive.

    Args:
        robot: The body.
        distance: How far, m.
        horizon: In what time, s.
        water: One of the named waters; if not given, the one that is nearest to the density
            of the body, so that what is trimmed for the sea swims in the sea.

    Raises:
        TaskError: The body is held to the world, has no actuator, or its card knows no water.
        RobotError: It has no shape that water could act on.
    """
    name = "swim"
    link = torso(robot, name)
    known = robot.card.water if robot.card is not None else None
    if robot.card is not None and known is None:
        raise TaskError(
            "its card has no [water]: it was not made to swim",
            where=f"task {name} of {robot.name}",
            fix="give a swimmer, such as sea_snake, or the volume that the body displaces",
        )
    density = robot.mass / known.displaced_volume_m3 if known is not None else 0.0
    water = water or min(WATERS, key=lambda each: abs(WATERS[each] - density))
    return Task(
        name=name,
        robot=robot,
        terms=travel_terms(robot, link, {}, distance),
        goals=travel_goals(robot, link, {}, distance),
        start=Start(),
        horizon=horizon,
        period=0.02,
        step=0.005,
        world=water,
        effects=world(water, robot).effects,
    )
