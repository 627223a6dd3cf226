"""A task whose commands stay within a user's limits, so that planning respects them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.body.spec import bare_spec
from morph.body.vary.apply import edited
from morph.errors import TransferError
from morph.policy.policy import actions_of
from morph.policy_transfer.live.limits import LimitGuard, Limits
from morph.search.trajectory.plant import bounds_of
from morph.task.task import Task


def within(task: Task, limits: Limits) -> Task:
    """Return the task for the same body whose actuators take no command beyond limits.

    What is simulated clips commands as the guard of a live target does, so that plans keep within
    the limits, and a policy that does not is foreseen to do as it will: clipped. The hash of the
    body stays, because policies for the one are policies for the other; its name tells the limits.
    `actions_of` tells the greater of two bounds that are not alike; the simulation has both.
    Limits of rates, positions and speeds are the guard's alone.

    Raises:
        TransferError: A limit names no part of the body, or leaves an actuator nothing.
    """
    robot = task.robot
    simulator = task.simulator()
    # The guard knows what is no limit.
    LimitGuard(limits, robot, simulator.model, task.period)
    low, high = bounds_of(simulator)
    spec = bare_spec(robot)
    lines = []
    for at, action in enumerate(actions_of(robot)):
        least, most = limits.command.get(action.actuator, (-np.inf, np.inf))
        least, most = max(least, float(low[at])), min(most, float(high[at]))
        if (least, most) == (low[at], high[at]):
            continue
        if not least < most:
            raise TransferError(
                f"{action.actuator} may be told nothing but {least:g} {action.unit}",
                where="limits of a live target",
                fix="give limits that lie apart",
            )
        actuator = spec.actuator(action.actuator)
        actuator.ctrllimited, actuator.ctrlrange = True, (least, most)
        lines.append(f"{action.actuator} in {least:g}..{most:g}")
    if not lines:
        return task
    name = "+".join((robot.name, *lines))
    return replace(task, robot=edited(robot, spec, name, robot.sha256))
