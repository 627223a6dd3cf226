from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.policy_transfer.baselines.source import Source
from morph.search.ddp import Plan
from morph.search.search import Problem
from morph.search.target import Experience
from morph.sim.threads import one_thread
from morph.task.task import Task
from morph.task.tasks import task

Acceleration = Callable[[Array, Array, Array], Array]
Made = Callable[..., Experience]


@pytest.fixture(autouse=True)
def alone_on_its_core() -> Iterator[None]:
    """Keep numerical libraries to one thread, as a rival that runs does."""
    with one_thread():
        yield


@pytest.fixture(scope="session")
def swing() -> Task:
    return task("swing-up", load("pendulum"))


@pytest.fixture(scope="session")
def source(swing: Task) -> Source:
    found = Plan(rows=96, runs=8, rounds=1).run(
        Problem(task=swing, simulator=swing.simulator()), seed=100
    )
    assert found.succeeded
    return Source(task=swing, policy=found.policy).with_experience(np.random.default_rng(100))


@pytest.fixture(scope="session")
def made(swing: Task) -> Made:
    """Return what makes a run of one joint by a law of our own, a = f(q, v, u)."""

    def run(law: Acceleration, *, seed: int, noise: float = 0.01) -> Experience:
        rng, steps = np.random.default_rng(seed), 50
        q, v = [np.zeros(1)], [np.zeros(1)]
        command = rng.uniform(-1.0, 1.0, (swing.samples - 1, 1))
        h = swing.period / steps
        for u in command:
            place, rate = q[-1], v[-1]
            for _ in range(steps):
                rate = rate + h * law(place, rate, u)
                place = place + h * rate
            q.append(place)
            v.append(rate)
        return Experience(
            position=np.array(q) + noise * rng.standard_normal((len(q), 1)),
            velocity=np.array(v) + noise * rng.standard_normal((len(v), 1)),
            command=command,
            period=swing.period,
            loss=0.0,
            success=False,
        )

    return run
