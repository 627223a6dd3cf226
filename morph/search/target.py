"""What trials are made on: the robot, or a simulation that stands for it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.latent.run import Run
from morph.policy.observing import Observer, addresses
from morph.policy.policy import Policy
from morph.search.evaluate import check_period
from morph.sim.closed_loop import Act
from morph.sim.drive import sensed
from morph.sim.simulator import Simulator
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
    """What the trial cost, as a referee beside the robot says: by true states, if simulated."""
    success: bool
    """Whether it reached every goal, as the same referee says."""

    @property
    def seconds(self) -> float:
        """How long it lasted, s."""
        return len(self.command) * self.period

    @property
    def run(self) -> Run:
        """What inference sees of it."""
        return Run(
            position=self.position,
            velocity=self.velocity,
            command=self.command,
            period=self.period,
        )


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
        """Return one run from a drawn start; what is recorded is what the policy saw.

        Raises:
            SearchError: The simulation became unstable.
        """
        task, simulator = self.task, self.simulator
        model: Any = simulator.model
        position, velocity = task.start.sample(task.robot, model, 1, rng)
        noise = rng.normal(scale=task.noise, size=(task.samples, model.nq + model.nv))

        def shown(q: Array, v: Array, at: int | slice) -> tuple[Array, Array]:
            reading = self._sensed(np.concatenate([q, v], axis=-1)) + noise[at]
            return reading[..., : model.nq], reading[..., model.nq :]

        act = self._driven(policy, shown)
        moved = run(task, simulator, act, position, velocity)
        if moved.stable is not None and not moved.stable.all():
            raise SearchError(
                "a trial became unstable, and what it shows is worth nothing",
                where=f"task {task.name} of {task.robot.name}",
                fix="take a smaller step, or check the body and the effects that act on it",
            )
        seen, speed = shown(moved.position[0], moved.velocity[0], slice(None))
        return Experience(
            position=seen,
            velocity=speed,
            command=moved.command[0, :-1],
            period=task.period,
            loss=float(task.loss(moved)[0]),
            success=bool(task.succeeded(moved)[0]),
        )

    def _driven(
        self, policy: Policy | Array, shown: Callable[[Array, Array, int], tuple[Array, Array]]
    ) -> Act:
        """Return what tells the body: a policy that sees what is shown, or commands as told."""
        period = self.task.period
        if not isinstance(policy, Policy):
            command = np.asarray(policy, dtype=float)
            return lambda q, v, time: command[None, min(round(time / period), len(command) - 1)]
        check_period(policy, self.task)
        observer = Observer(policy, self.task.robot, self.simulator.model, 1)
        return lambda q, v, time: policy.act(
            observer.see(*shown(q, v, round(time / period))), np.full(1, time)
        )

    def _sensed(self, state: Array) -> Array:
        """Return states (..., nq + nv) as sensors under the effects report them."""
        for channel, at in addresses(self.task.robot, self.simulator.model).items():
            state[..., at] = sensed(self.simulator.effects, channel, state[..., at])
        return state
