"""What trials are made on: the robot, or a simulation that stands for it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.policy.policy import Policy
from morph.search.evaluate import attempt
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class Experience:
    """What one trial showed: noisy states at the control times, and the commands between."""

    position: Array
    """Observed `qpos`, shape (samples, nq)."""
    velocity: Array
    """Observed `qvel`, shape (samples, nv)."""
    command: Array
    """What was commanded from each time on, shape (samples - 1, nu)."""
    period: float
    """Time from one sample to the next, s."""
    loss: float
    """What the trial cost; of a simulated target by its true states."""
    success: bool
    """Whether it reached every goal."""

    @property
    def seconds(self) -> float:
        """How long it lasted, s."""
        return len(self.command) * self.period


class Target(ABC):
    """What a policy can be tried on."""

    @abstractmethod
    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        """Return what one run shows.

        Args:
            policy: A policy, or a command for each control period, shape (periods, nu).
            rng: The chance of the start and of the observations.
        """


@dataclass(frozen=True, kw_only=True)
class Simulated(Target):
    """A simulation that stands for the robot: no search may look inside."""

    task: Task
    """What is tried."""
    simulator: Simulator
    """The simulation."""

    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        """Return one run from a drawn start, its states seen through the task's noise."""
        task = self.task
        if isinstance(policy, Policy):
            moved = attempt(task, policy, self.simulator, rows=1, rng=rng)
        else:
            moved = self._open(policy, rng)
        noise = rng.normal(scale=task.noise, size=(2, task.samples, self.simulator.model.nq))
        velocity = moved.velocity[0]
        return Experience(
            position=moved.position[0] + noise[0],
            velocity=velocity + noise[1][:, : velocity.shape[1]],
            command=moved.command[0, :-1],
            period=task.period,
            loss=float(task.loss(moved)[0]),
            success=bool(task.succeeded(moved)[0]),
        )

    def _open(self, command: Array, rng: np.random.Generator) -> Moved:
        task, simulator = self.task, self.simulator
        position, velocity = task.start.sample(task.robot, simulator.model, 1, rng)
        told = np.asarray(command, dtype=float)

        def act(q: Array, v: Array, time: float) -> Array:
            return told[None, min(round(time / task.period), len(told) - 1)]

        return run(task, simulator, act, position, velocity)
