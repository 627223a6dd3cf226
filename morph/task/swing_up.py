"""Swing up: from hanging to standing upright, and there to stay."""

from __future__ import annotations

from morph.body.robot import Robot
from morph.task.balance import LAST, upright_goals
from morph.task.chain import end_of, place_of, posture, stepping
from morph.task.quantity import Point
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Term

WIDTH = 0.5
"""Width of the cost, in lengths of the stretched chain: 0.25 m for the thesis' pole of 0.5 m."""


def swing_up(robot: Robot) -> Task:
    """Return the task to swing a chain up from hanging, by the distance of its end from the top.

    Source: Gamboa Higuera 2015, section 2 (cart-pole: 3 s, 0.05 s, width 0.25 m); Deisenroth
    and Rasmussen 2011.

    Raises:
        TaskError: The body has no hinges that swing in gravity, or cannot reach the top.
    """
    name = "swing-up"
    top = posture(robot, name, upright=True)
    link, offset = end_of(robot)
    end, length = place_of(robot, top, link)
    tip = Term(
        name="tip",
        quantity=Point(link=link, offset=offset),
        target=(float(end[0]), float(end[1]), float(end[2])),
        width=WIDTH * length,
        norm="saturating",
    )
    step, integrator = stepping(robot)
    return Task(
        name=name,
        robot=robot,
        terms=(tip,),
        goals=upright_goals(robot, top, last=LAST),
        step=step,
        integrator=integrator,
        start=Start(position=posture(robot, name, upright=False)),
    )
