"""How a policy does: many noisy runs of a task in one batch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Mask
from morph.errors import SearchError
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.task import Task

ROWS = 100
"""Runs by which a policy is judged at the end, if nothing else is said."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """How a policy did."""

    loss: Array
    """What each run cost, shape (rows,)."""
    success: Mask
    """Which runs reached every goal, shape (rows,)."""

    @property
    def mean(self) -> float:
        """The mean loss."""
        return float(self.loss.mean())

    @property
    def share(self) -> float:
        """The share of runs that reached every goal."""
        return float(self.success.mean())


def check_period(policy: Policy, task: Task) -> None:
    """Refuse a policy whose control period is not the task's: its loss would count otherwise.

    Raises:
        SearchError: It is another.
    """
    if abs(policy.period - task.period) > 1e-9:
        raise SearchError(
            f"the policy commands every {policy.period:g} s, and the task counts every "
            f"{task.period:g} s",
            where=f"task {task.name} of {task.robot.name}",
            fix="give a policy of the task's control period",
        )


def attempt(
    task: Task,
    policy: Policy,
    simulator: Simulator,
    *,
    rows: int,
    rng: np.random.Generator | None,
) -> Moved:
    """Return what a body does under a policy, from drawn starts, seen through noise.

    Without `rng` every run begins in the middle of the start and is seen as it is. The commands
    are in MuJoCo's order of actuators, which is the robot's.

    Raises:
        SearchError: The policy's control period is not the task's.
        SimulationFailed: The simulation cannot run in a closed loop.
    """
    check_period(policy, task)
    position, velocity = task.start.sample(task.robot, simulator.model, rows, rng)
    noise = 0.0 if rng is None else task.noise
    observer = Observer(
        policy,
        task.robot,
        simulator.model,
        rows,
        rng=rng,
        noise=noise,
        effects=simulator.effects,
    )

    def act(q: Array, v: Array, time: float) -> Array:
        return policy.act(observer.see(q, v), np.full(rows, time))

    return run(task, simulator, act, position, velocity, period=policy.period)


def evaluate(
    task: Task,
    policy: Policy,
    simulator: Simulator,
    *,
    rng: np.random.Generator,
    rows: int = ROWS,
) -> Score:
    """Return how a policy does over many noisy runs."""
    moved = attempt(task, policy, simulator, rows=rows, rng=rng)
    return Score(loss=task.loss(moved), success=task.succeeded(moved))
