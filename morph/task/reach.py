"""Reach: the end of an arm goes to a point and stays there."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.body.limbs import torso_of
from morph.body.postures import posture_of
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.task.arm import Arm
from morph.task.quantity import JointSpeeds, Point
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Goal, Term

WITHIN = 0.01
"""How near the end must come, m."""

LAST = 0.5
"""For how long to the end it must stay there, s."""

PERIOD = 0.02
"""How long each command is held, s."""


def reach(
    robot: Robot, target: tuple[float, float, float] | None = None, *, within: float = WITHIN
) -> Task:
    """Return the task to bring an arm's end to a point within 3 s, and to keep it there.

    Args:
        robot: An arm that is held to the world.
        target: The point, m; if not given, one that is far from where the end rests.
        within: How near it must come, m.

    Raises:
        TaskError: The body is not held to the world, drives no joint, or its end cannot come
            to that point; the message says how near it comes.
    """
    name = "reach"
    if torso_of(robot) is not None:
        raise TaskError(
            "it is not held to the world",
            where=f"task {name} of {robot.name}",
            fix="give an arm, such as so101",
        )
    arm = Arm(robot)
    if not len(arm.low):
        raise TaskError(
            "no hinge or slide of it is driven",
            where=f"task {name} of {robot.name}",
            fix="give an arm, such as so101",
        )
    point = arm.far() if target is None else np.asarray(target, dtype=float)
    _, short = arm.posture(point)
    if not short <= within:
        raise TaskError(
            f"its end comes no nearer to {_said(point)} than {short:.3g} m, "
            f"and is asked for within {within:g} m",
            where=f"task {name} of {robot.name}",
            fix=f"give a point that it can reach, such as {_said(arm.far())}",
        )
    end = Point(link=arm.link, offset=arm.offset)
    speeds = JointSpeeds(joints=arm.joints)
    requested = (float(point[0]), float(point[1]), float(point[2]))
    return Task(
        name=name,
        robot=robot,
        terms=(
            Term(
                name="end",
                quantity=end,
                target=requested,
                width=0.1,
                weight=PERIOD,
                norm="saturating",
            ),
            # At first a tenth of a metre is all; in the end it is the last millimetre.
            Term(name="end, finely", quantity=end, target=requested, width=within, last_only=True),
            Term(
                name="speed",
                quantity=speeds,
                target=(0.0,) * len(arm.joints),
                width=10.0,
                weight=PERIOD,
            ),
        ),
        goals=(Goal(name="end", quantity=end, target=requested, within=within, last=LAST),),
        start=Start(position=posture_of(robot)),
        horizon=3.0,
        period=PERIOD,
        step=0.002,
    )


def _said(point: Array) -> str:
    return "(" + ", ".join(f"{each:.3g}" for each in point) + ") m"
