"""Runs of the cart-pole, driven by chance, as a robot with noisy sensors shows them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.model.latent.run import Run
from morph.physics.effect import Effect
from morph.search.target import Simulated
from morph.task.swing_up import swing_up

NOISE = 0.01

Shown = Callable[..., Run]


@pytest.fixture(scope="session")
def cartpole() -> Robot:
    return load("cartpole")


@pytest.fixture(scope="session")
def shown() -> Shown:
    """What a cart-pole shows in 3 s under commands that are held for 0.2 s each."""

    def record(robot: Robot, effects: tuple[Effect, ...] = (), seed: int = 0) -> Run:
        task = swing_up(robot)
        rng = np.random.default_rng(seed)
        command = np.repeat(rng.uniform(-8.0, 8.0, (15, 1)), 4, axis=0)
        return Simulated(task=task, simulator=task.simulator(effects)).trial(command, rng).run

    return record
