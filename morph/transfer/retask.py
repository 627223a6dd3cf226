"""The same task for a body that was found to be another than described."""

from __future__ import annotations

from dataclasses import replace

from morph.body.robot import Robot
from morph.errors import TaskError
from morph.task.task import Task
from morph.task.tasks import TASKS


def task_for(task: Task, robot: Robot) -> Task:
    """Return a task as another body of the same parts is asked to do it.

    A task that is one of `TASKS` as its body gets it is made anew, so that its lengths and limits
    are the new body's; any other is kept as it is, number for number.
    """
    if robot is task.robot:
        return task
    if task.name in TASKS:
        usual = TASKS[task.name](task.robot)
        if usual.sha256 == task.sha256:
            return _settled(TASKS[task.name](robot), task)
    return replace(task, robot=robot)


def _settled(found: Task, task: Task) -> Task:
    """Return a task with the clock of the first: runs of both must be comparable."""
    try:
        return replace(found, step=task.step, integrator=task.integrator, period=task.period)
    except TaskError:
        return replace(task, robot=found.robot)
