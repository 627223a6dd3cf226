"""Ride: a rider on a driven board goes a metre ahead, stops there, and does not fall."""

from __future__ import annotations

from dataclasses import replace

from morph.body.robot import Robot
from morph.errors import TaskError
from morph.task.balance import balance
from morph.task.chain import slides_of
from morph.task.quantity import AngleSum, JointPositions
from morph.task.task import Task

LEAN = 0.5
"""Farthest that a link may lean on the way, rad: to speed up is to lean."""

LAST = 0.5
"""For how long to the end the board must be where it was asked, s."""


def ride(robot: Robot, *, distance: float = 1.0) -> Task:
    """Return the task to carry a chain so far along its slide within 5 s, upright all the way.

    Raises:
        TaskError: The body has no driven slide, or no hinges that swing in gravity.
    """
    name = "ride"
    slides = tuple(joint.name for joint in slides_of(robot, driven=True))
    if len(slides) != 1:
        raise TaskError(
            f"it has {len(slides)} driven slides, and rides on one",
            where=f"task {name} of {robot.name}",
            fix="give a body on a driven board, such as rider_rigid_driven",
        )
    still = balance(robot)
    place = JointPositions(joints=slides)
    terms = tuple(
        replace(each, target=(distance,), width=0.5 * distance, norm="saturating")
        if each.quantity == place
        else each
        for each in still.terms
    )
    goals = tuple(
        replace(each, within=LEAN)
        if isinstance(each.quantity, AngleSum)
        else replace(each, target=(distance,), last=LAST)
        for each in still.goals
    )
    return replace(still, name=name, terms=terms, goals=goals)
