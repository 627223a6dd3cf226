"""What a body did in a task: every state, and what its actuators were told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.app.cli.policy_rollout import driven
from morph.arrays import Array
from morph.body.robot import Robot
from morph.policy.pattern import pattern
from morph.policy.policy import Policy
from morph.sim.drive import received
from morph.task.moved import Moved
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedRun:
    """Every step of one run."""

    robot: Robot
    """The body."""
    model: Any
    """The `mujoco.MjModel` that ran."""
    time: Array
    """s, shape (samples,); a step apart."""
    position: Array
    """MuJoCo's `qpos`, shape (samples, nq)."""
    velocity: Array
    """MuJoCo's `qvel`, shape (samples, nv)."""
    told: Array
    """What the policy commands from each sample on, shape (samples, nu); the last is held."""
    control: Array
    """What of it arrives at the actuators: MuJoCo's `ctrl`, same shape."""
    why: str = ""
    """If it ended early: why, in a sentence."""


def ran(
    task: Task, policy: Policy | None, *, seed: int = 0, seconds: float | None = None
) -> SimulatedRun:
    """Return one run of a task from a start drawn as the task says, seen without noise.

    From the very middle of its start a pole that nothing holds would stand for ever.

    Args:
        task: The task, in its world.
        policy: What commands the body; without one every command is zero.
        seed: Of the start; bodies alike begin alike.
        seconds: How long, if not as long as the task.

    Raises:
        SimulationFailed: Not even the first step can be made.
        PolicyError: The body lacks what the policy observes.
    """
    simulator = task.simulator()
    model: Any = simulator.model
    q, v = task.start.sample(task.robot, model, 1, np.random.default_rng(seed))
    moved, why = driven(
        simulator,
        pattern(task.robot, {}, period=task.period) if policy is None else policy,
        seconds=task.horizon if seconds is None else seconds,
        state=(q[0], v[0]),
    )
    steps = len(moved.time) - 1
    given, control = np.zeros((2, steps + 1, model.nu))
    for name, values in moved.command.items():
        at = model.actuator(name).id
        given[:steps, at] = values
        control[:steps, at] = received(simulator.effects, name, values, simulator.step)
    # There is no step after the last sample; what was told before it is held.
    given[steps], control[steps] = given[steps - 1], control[steps - 1]
    return SimulatedRun(
        robot=task.robot,
        model=model,
        time=moved.time,
        position=moved.position,
        velocity=moved.velocity,
        told=given,
        control=control,
        why="" if why is None else why.what,
    )


def at_control_times(task: Task, run: SimulatedRun) -> Moved:
    """Return a run as the terms and goals of its task see it, each control period.

    Those count beyond neither the task's horizon nor the run's end.
    """
    each = round(task.period / task.step)
    rows = slice(0, min(len(run.time), (task.samples - 1) * each + 1), each)
    return Moved(
        robot=task.robot,
        model=run.model,
        time=run.time[rows],
        position=run.position[rows],
        velocity=run.velocity[rows],
        command=run.told[rows],
    )
