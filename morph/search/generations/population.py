"""Many policies tried at once: every run of every policy is a row of one batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.search.evaluate import Score
from morph.sim.simulator import Simulator
from morph.task.run import run
from morph.task.task import Task


def tried(
    task: Task,
    policies: Sequence[Policy],
    simulator: Simulator,
    *,
    runs: int,
    rng: np.random.Generator,
) -> Score:
    """Return how each policy did in each of some noisy runs, shape (policies, runs).

    All policies begin from the same starts: so they are compared by what they are, and not by
    their luck.

    Raises:
        SimulationFailed: The simulation cannot run in a closed loop.
    """
    q, v = task.start.sample(task.robot, simulator.model, runs, rng)
    observers = [
        Observer(
            each,
            task.robot,
            simulator.model,
            runs,
            rng=rng,
            noise=task.noise,
            effects=simulator.effects,
        )
        for each in policies
    ]
    clock = np.empty(runs)

    def act(position: Array, velocity: Array, time: float) -> Array:
        clock[:] = time
        command = np.empty((len(position), simulator.model.nu))
        for at, (policy, observer) in enumerate(zip(policies, observers, strict=True)):
            rows = slice(at * runs, (at + 1) * runs)
            # Without observations there is nothing to draw noise for.
            seen = (
                observer.see(position[rows], velocity[rows])
                if policy.observation
                else np.empty((runs, 0))
            )
            command[rows] = policy.act(seen, clock)
        return command

    many = len(policies)
    starts = (np.tile(q, (many, 1)), np.tile(v, (many, 1)))
    moved = run(task, simulator, act, *starts, period=policies[0].period)
    return Score(
        loss=task.loss(moved).reshape(many, runs),
        success=task.succeeded(moved).reshape(many, runs),
    )
