"""Steer: who rolls on a board comes aside by leaning, and does not fall."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.task.quantity import Point
from morph.task.stand import stand
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Goal, Term
from morph.task.torso import torso

SPEED = 0.5
"""How fast the board rolls at first, m/s."""


def steer(robot: Robot, *, aside: float = 0.2, speed: float = SPEED) -> Task:
    """Return the task to come so far to the left within 5 s, on a board that rolls.

    Args:
        robot: A rider that stands free on a board with wheels.
        aside: How far, m.
        speed: How fast the board rolls at first, m/s.

    Raises:
        TaskError: The body has no board that floats under it.
    """
    name = "steer"
    rider = torso(robot, name)
    boards = [joint.link for joint in robot.joints if joint.kind == "free"]
    if len(boards) != 1 or boards[0] == rider:
        raise TaskError(
            "it does not stand on a board that rolls",
            where=f"task {name} of {robot.name}",
            fix="give a rider on a board, such as humanoid_skateboard",
        )
    still = stand(robot, name=name)
    left = Point(link=boards[0], axes="y")
    rolling = {f"{boards[0]}.linear_velocity.x": speed, **_wheels(robot, speed)}
    term = Term(
        name="aside", quantity=left, target=(1.5 * aside,), width=aside, last_only=True, weight=5.0
    )
    return replace(
        still,
        terms=(term, *(each for each in still.terms if each.name != "place")),
        goals=(*still.goals, Goal(name="aside", quantity=left, target=(aside,), beyond=True)),
        start=Start(position=still.start.position, speed=rolling, moving=still.start.moving),
    )


def _wheels(robot: Robot, speed: float) -> dict[str, float]:
    """Return how fast each wheel turns that rolls: what no motor drives and turns about y."""
    driven = set(robot.driven)
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    speeds = {}
    for joint in robot.joints:
        if joint.kind != "hinge" or joint.limits is not None or joint.name in driven:
            continue
        here = model.joint(joint.name)
        # Its axle is as high over the floor as the wheel's radius.
        radius = float(data.xanchor[here.id][2])
        along = float(data.xaxis[here.id][1])
        if abs(along) > 0.9 and radius > 0.0:
            speeds[joint.name] = along * speed / radius
    return speeds
