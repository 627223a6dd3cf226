"""What a learned policy is held against: nothing, chance, the sign turned, another's policy."""

from __future__ import annotations

import time

import numpy as np

from morph.arrays import Array
from morph.body.load import load
from morph.policy.policy import Policy, actions_of
from morph.search.evaluate import attempt
from morph.search.search import Problem
from morph.search.searches import search
from morph.search.target import Simulated
from morph.sim.integrator import Integrator
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.task import Task
from morph.task.tasks import task

ROWS = 100
"""Runs of each control."""


def controls(task_name: str, body: str, *, seed: int) -> dict[str, tuple[float, float]]:
    """Return mean loss and share of successes of each control."""
    wanted = task(task_name, load(body))
    simulator = wanted.simulator()
    low, high = (
        np.array([getattr(each, side) for each in actions_of(wanted.robot)])
        for side in ("low", "high")
    )
    rng = np.random.default_rng(seed)
    chance = rng.uniform(low, high, (wanted.samples, ROWS, len(low)))
    found = {
        "doing nothing": _told(wanted, simulator, np.zeros_like(chance), seed),
        "random commands": _told(wanted, simulator, chance, seed),
    }
    problem = Problem(
        task=wanted, simulator=simulator, target=Simulated(task=wanted, simulator=simulator)
    )
    learned = search("ddp")().run(problem, seed=seed)
    seen = attempt(wanted, learned.policy, simulator, rows=ROWS, rng=np.random.default_rng(seed))
    open_loop = seen.command.mean(axis=0)[:, None].repeat(ROWS, axis=1)
    found["the learned policy"] = _score(wanted, seen)
    found["its commands without feedback"] = _told(wanted, simulator, open_loop, seed)
    found["its commands with the sign turned"] = _told(wanted, simulator, -open_loop, seed)
    shuffled = rng.permutation(open_loop, axis=0)
    found["its commands in another order"] = _told(wanted, simulator, shuffled, seed)
    return found


def _told(wanted: Task, simulator: Simulator, command: Array, seed: int) -> tuple[float, float]:
    """Return the score of commands (samples, rows, nu) that depend on nothing seen."""
    rng = np.random.default_rng(seed)
    q, v = wanted.start.sample(wanted.robot, simulator.model, command.shape[1], rng)
    moved = run(wanted, simulator, lambda q, v, time: command[round(time / wanted.period)], q, v)
    return _score(wanted, moved)


def _score(wanted: Task, moved: Moved) -> tuple[float, float]:
    return float(wanted.loss(moved).mean()), float(wanted.succeeded(moved).mean())


def throughput(body: str, policy: Policy, *, rows: int, integrator: Integrator) -> float:
    """Return steps a second of a closed loop with a policy, observations and noise included.

    A step of RK4 evaluates the body four times, one of implicitfast once, and half as long.
    """
    wanted = task("swing-up", load(body))
    step = wanted.step if integrator == "rk4" else wanted.step / 2.0
    simulator = Simulator(wanted.robot, wanted.effects, step=step, integrator=integrator)
    attempt(wanted, policy, simulator, rows=rows, rng=np.random.default_rng(0))
    began = time.perf_counter()
    attempt(wanted, policy, simulator, rows=rows, rng=np.random.default_rng(1))
    return rows * round(wanted.horizon / step) / (time.perf_counter() - began)
