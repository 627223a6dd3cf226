"""Hold: what is driven stays in its posture against gravity."""

from __future__ import annotations

from collections.abc import Mapping

from morph.body.limbs import torso_of
from morph.body.postures import posture_of
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.task.arm import Arm
from morph.task.quantity import JointPositions, JointSpeeds
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Goal, Term
from morph.task.travel import effort_terms

WITHIN = 0.03
"""Farthest that a joint may be from its posture, rad or m."""

HORIZON, PERIOD = 5.0, 0.01
"""How long a run is, and how long each command is held, s."""

SETTLE = 1.0
"""How long joints have to come to rest before they must be within it, s."""


def hold(robot: Robot, posture: Mapping[str, float] | None = None) -> Task:
    """Return the task to keep every driven joint in a posture for 5 s; a servo must not sag.

    Args:
        robot: A body that is held to the world, such as an arm.
        posture: Positions of joints by name, rad or m; the others as `posture_of` has them.

    Raises:
        TaskError: The body moves freely, no joint of it is driven, or a posture is beyond the
            range of its joint.
    """
    name = "hold"
    where = f"task {name} of {robot.name}"
    if torso_of(robot) is not None:
        raise TaskError(
            "it is not held to the world", where=where, fix="take the task stand, or give an arm"
        )
    requested = Arm(robot).rest() | dict(posture_of(robot)) | dict(posture or {})
    joints = robot.driven
    if not joints:
        raise TaskError(
            "no joint of it is driven", where=where, fix="give a body with motors or servos"
        )
    for joint in (robot.joint(each) for each in joints):
        low, high = joint.limits or (-float("inf"), float("inf"))
        if not low <= requested[joint.name] <= high:
            raise TaskError(
                f"joint {joint.name!r} is to stay at {requested[joint.name]:.3g} {joint.unit}, "
                f"and its range is {low:.3g} to {high:.3g}",
                where=where,
                fix="give a posture within the ranges",
            )
    target = tuple(requested[each] for each in joints)
    place = JointPositions(joints=joints)
    still = (0.0,) * len(joints)
    return Task(
        name=name,
        robot=robot,
        terms=(
            Term(name="posture", quantity=place, target=target, width=WITHIN, weight=PERIOD),
            Term(
                name="speed",
                quantity=JointSpeeds(joints=joints),
                target=still,
                width=1.0,
                weight=PERIOD,
            ),
            *effort_terms(robot, weight=1e-3 * PERIOD),
        ),
        goals=(
            Goal(
                name="posture",
                quantity=place,
                target=target,
                within=WITHIN,
                last=HORIZON - SETTLE,
            ),
        ),
        start=Start(position=requested),
        horizon=HORIZON,
        period=PERIOD,
        step=0.001,
    )
