"""The cart-pole as a source, a plan for it, and targets with other parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.load import load
from morph.model.latent.unknowns import turned
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.ddp import Plan
from morph.search.search import Problem
from morph.search.target import Experience, Simulated
from morph.task.swing_up import swing_up

Changed = Callable[..., Simulated]


@pytest.fixture(scope="session")
def source() -> SimulatedTask:
    """The swing-up of the cart-pole, as it is described."""
    task = swing_up(load("cartpole"))
    return SimulatedTask(task=task, simulator=task.simulator())


@pytest.fixture(scope="session")
def plan(source: SimulatedTask) -> Policy:
    """A plan that leaves a fifth of the command's range free; 8 N are enough on the source."""
    problem = Problem(task=source.task, simulator=source.simulator)
    search = Plan(margin=0.2, rows=512, keep=2, rounds=1, runs=8)
    return search.run(problem, seed=100).policy


@pytest.fixture(scope="session")
def changed() -> Changed:
    """Return targets with figures multiplied: `changed("damping:slide", 11.0)`."""

    def target(figure: str, factor: float) -> Simulated:
        task = swing_up(turned(load("cartpole"), {figure: factor}))
        return Simulated(task=task, simulator=task.simulator())

    return target


@pytest.fixture(scope="session")
def rough(changed: Changed) -> Simulated:
    """The target with 1.1 N s/m of friction on its slide, the source having 0.1 N s/m."""
    return changed("damping:slide", 11.0)


@pytest.fixture(scope="session")
def run(rough: Simulated, plan: Policy) -> Experience:
    """The plan of the source on that target."""
    return rough.trial(plan, np.random.default_rng(0))
