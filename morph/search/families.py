"""Which policies suit a task: the family that a search chooses from if none is given."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from morph.search.family import Family
from morph.search.gait import gait
from morph.search.hold import hold
from morph.task.arm import Arm
from morph.task.task import Task


def _gait(task: Task) -> Family:
    return gait(task.robot, period=task.period)


def _hold(task: Task) -> Family:
    return hold(task.robot, task.start.position, period=task.period)


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
    "reach": _posture,
    "swim": _gait,
    "walk": _gait,
}
"""The family of each task by its name; all others hold the posture in which they start."""


def family_of(task: Task) -> Family:
    """Return the policies that a search by trying chooses from.

    Raises:
        SearchError: The body has no actuator.
    """
    return FAMILIES.get(task.name, _hold)(task)
