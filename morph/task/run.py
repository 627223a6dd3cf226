"""A task's horizon in a closed loop: what a body does when each command depends on its state."""

from __future__ import annotations

from morph.arrays import Array
from morph.sim.closed_loop import Act, closed_loop
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.task import Task


def run(
    task: Task,
    simulator: Simulator,
    act: Act,
    position: Array,
    velocity: Array,
    *,
    period: float | None = None,
) -> Moved:
    """Return what each row does from its start on until the horizon ends.

    Args:
        task: Gives the horizon, and the control period if none is named.
        simulator: The body.
        act: What is told, asked once each control period for all rows.
        position: Where each row starts, MuJoCo's `qpos`, shape (rows, nq).
        velocity: How fast, `qvel`, shape (rows, nv).
        period: How long each command is held, s.

    Raises:
        SimulationFailed: The simulation cannot run in a closed loop.
    """
    loop = closed_loop(
        simulator,
        act,
        position,
        velocity,
        period=task.period if period is None else period,
        seconds=task.horizon,
    )
    return Moved(
        robot=task.robot,
        model=simulator.model,
        time=loop.time,
        position=loop.position,
        velocity=loop.velocity,
        command=loop.command,
        stable=loop.stable,
    )
