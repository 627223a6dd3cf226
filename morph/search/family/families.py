"""Which policies suit a task: the family that a search chooses from if none is given."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from morph.body.limbs import torso_of
from morph.body.roles import actuator_roles
from morph.physics.worlds import is_floor
from morph.search.family.family import Family
from morph.search.family.follow import follow
from morph.search.family.gait import gait
from morph.search.family.paces import paces
from morph.search.family.posture_policies import hold
from morph.search.family.stride import stride
from morph.task.arm import Arm
from morph.task.task import Task
from morph.task.torso import legs_of
from morph.task.track import Course

MOST_ROLES = 6
"""Most roles that swing in a gait; of a body with more, such as a person, the legs alone do."""


def _gait(task: Task) -> Family:
    robot = task.robot
    motors = all(each.kind == "motor" and each.joint for each in robot.actuators)
    if motors and is_floor(task.world or ""):
        return stride(robot, task.start.position, seconds=task.horizon, period=task.period)
    roles, walking = actuator_roles(robot), None
    if len({role.order for role in roles.values()}) > MOST_ROLES:
        legs = legs_of(robot)
        named = [roles[each.name].name for each in robot.actuators if each.joint in legs]
        walking = tuple(dict.fromkeys(named))
    posture = task.start.position
    if any(posture.get(each.joint or "", 0.0) for each in robot.actuators):
        return paces(robot, posture, roles=walking, period=task.period)
    return gait(robot, period=task.period, roles=walking)


LEAN = 0.4
"""How far joints may be told to lean where a rider is to steer, rad."""


def _course(task: Task) -> Family:
    course = task.goals[0].quantity
    if isinstance(course, Course) and torso_of(task.robot) is None:
        return follow(task.robot, course, seconds=task.horizon, period=task.period)
    return _gait(task)


def _hold(task: Task) -> Family:
    return hold(task.robot, task.start.position, period=task.period)


def _carry(task: Task) -> Family:
    arm = Arm(task.robot)
    posture = np.array([task.start.position[name] for name in arm.joints])
    efforts = dict(zip(arm.joints, arm.holding(posture).tolist(), strict=True))
    return hold(task.robot, task.start.position, carried=efforts, period=task.period)


def _lean(task: Task) -> Family:
    return hold(task.robot, task.start.position, period=task.period, widest=LEAN)


def _posture(task: Task) -> Family:
    arm = Arm(task.robot)
    posture, _ = arm.posture(np.array(task.goals[0].target))
    efforts = arm.holding(posture)
    return hold(
        task.robot,
        dict(zip(arm.joints, posture.tolist(), strict=True)),
        carried=dict(zip(arm.joints, efforts.tolist(), strict=True)),
        period=task.period,
    )


FAMILIES: Mapping[str, Callable[[Task], Family]] = {
    "gait-speed": _gait,
    "hold": _carry,
    "hop": _gait,
    "reach": _posture,
    "steer": _lean,
    "swim": _gait,
    "track": _course,
    "walk": _gait,
}
"""The family of each task by its name; all others hold the posture in which they start."""


def family_of(task: Task) -> Family:
    """Return the policies that a search by trying chooses from.

    Raises:
        SearchError: The body has no actuator.
    """
    return FAMILIES.get(task.name, _hold)(task)
