"""Noisy runs of cart-poles with one figure changed, under commands that excite all of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.latent.unknowns import turned, unknowns
from morph.sim.rollout import Variant, rollout
from morph.task.swing_up import swing_up
from morph.task.task import Task

Recorded = Callable[..., Run]

NOISE = np.full(4, 0.01)


@pytest.fixture(scope="session")
def task() -> Task:
    return swing_up(load("cartpole"))


@pytest.fixture(scope="session")
def hypothesis(task: Task) -> Hypothesis:
    return Hypothesis(robot=task.robot, step=task.step, knobs=unknowns(task.robot))


@pytest.fixture(scope="session")
def recorded(task: Task) -> Recorded:
    def run(
        factors: Mapping[str, float] | None = None, *, seed: int = 100, noise: Array = NOISE
    ) -> Run:
        robot = turned(task.robot, factors) if factors else task.robot
        simulator = swing_up(robot).simulator()
        rng = np.random.default_rng(seed)
        # Full pushes that last 0.1 to 0.4 s swing the pole by some radians.
        told = np.repeat(10.0 * rng.choice([-1.0, 1.0], 30), rng.integers(2, 9, 30))[:60, None]
        held = np.repeat(told, round(task.period / task.step), axis=0)
        only = Variant(model=simulator.model, effects=())
        zero = np.zeros((1, 2))
        q, v = rollout([only], np.zeros(1, dtype=int), zero, zero, held[None])
        every = round(task.period / task.step)
        state = np.concatenate([q, v], axis=2)[0, ::every]
        state = state + noise * rng.standard_normal(state.shape)
        return Run(position=state[:, :2], velocity=state[:, 2:], command=told, period=task.period)

    return run
