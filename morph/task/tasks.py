"""Every task by its name, and the tasks of a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from morph.body.robot import Robot
from morph.errors import TaskError
from morph.nearest import nearest
from morph.task.balance import balance
from morph.task.gait_speed import gait_speed
from morph.task.hold import hold
from morph.task.hop import hop
from morph.task.reach import reach
from morph.task.ride import ride
from morph.task.stand import stand
from morph.task.steer import steer
from morph.task.swim import swim
from morph.task.swing_up import swing_up
from morph.task.task import Task
from morph.task.track import track
from morph.task.walk import walk

TASKS: Mapping[str, Callable[[Robot], Task]] = {
    "balance": balance,
    "gait-speed": gait_speed,
    "hold": hold,
    "hop": hop,
    "reach": reach,
    "ride": ride,
    "stand": stand,
    "steer": steer,
    "swim": swim,
    "swing-up": swing_up,
    "track": track,
    "walk": walk,
}
"""What each task is made by."""


def check_name(name: str) -> None:
    """Refuse a name of no task, before a robot is read for it.

    Raises:
        TaskError: There is no such task.
    """
    if name not in TASKS:
        raise TaskError(
            f"there is no task {name!r}; there are {', '.join(TASKS)}",
            where="morph.task",
            fix=f"the nearest are {nearest(name, tuple(TASKS))}; `morph list tasks` says more",
        )


def task(name: str, robot: Robot) -> Task:
    """Return a task of a robot by its name.

    Raises:
        TaskError: There is no such task, or the body cannot be asked to do it.
    """
    check_name(name)
    return TASKS[name](robot)


def tasks_of(robot: Robot) -> tuple[str, ...]:
    """Return the names of the tasks that a robot's card names, those that there are."""
    named = robot.card.tasks if robot.card is not None else ()
    return tuple(name for name in named if name in TASKS)
