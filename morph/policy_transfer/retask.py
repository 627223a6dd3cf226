"""The same task for a body that was found to be another than described."""

from __future__ import annotations

from dataclasses import replace

from morph.body.robot import Robot
from morph.errors import TaskError
from morph.task.task import Task
from morph.task.tasks import TASKS


def task_for(task: Task, robot: Robot) -> Task:
    """Return a task as another body of the same parts is asked to do it.

    A task that is one of `TASKS` as its body gets it, but for its start, its clock and its noise,
    is made anew, so that its lengths and limits are the new body's; any other is kept as it is,
    number for number.
    """
    if robot is task.robot:
        return task
    if task.name in TASKS:
        try:
            usual, result = TASKS[task.name](task.robot), TASKS[task.name](robot)
            if _settled(usual, task).sha256 == task.sha256:
                return _settled(result, task)
        except TaskError:
            # The body as it was found cannot be asked so: its old lengths must do.
            pass
    return replace(task, robot=robot)


def _settled(result: Task, task: Task) -> Task:
    """Return a task with what of another does not depend on the body's size."""
    return replace(
        result,
        start=replace(result.start, spread=task.start.spread, moving=task.start.moving),
        horizon=task.horizon,
        period=task.period,
        step=task.step,
        integrator=task.integrator,
        noise=task.noise,
        world=task.world,
        effects=task.effects,
        observes=task.observes,
    )
