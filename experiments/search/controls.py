"""What a learned policy is held against: nothing, chance, the sign turned, another's policy."""

from __future__ import annotations

import time
from dataclasses import dataclass

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


@dataclass(frozen=True, kw_only=True)
class Control:
    """Runs of one control, by which it is judged as the searches are."""

    name: str
    """What is done."""
    losses: tuple[float, ...]
    """Loss of each run."""
    successes: tuple[bool, ...]
    """Whether each run reached every goal."""

    @property
    def loss(self) -> float:
        """Mean loss."""
        return float(np.mean(self.losses))

    @property
    def share(self) -> float:
        """Share of the runs that reached every goal."""
        return float(np.mean(self.successes))


def controls(task_name: str, body: str, *, seed: int) -> list[Control]:
    """Return what doing nothing, random commands, and spoiled commands of a policy give."""
    wanted = task(task_name, load(body))
    simulator = wanted.simulator()
    low, high = (
        np.array([getattr(each, side) for each in actions_of(wanted.robot)])
        for side in ("low", "high")
    )
    rng = np.random.default_rng(seed)
    chance = rng.uniform(low, high, (wanted.samples, ROWS, len(low)))
    problem = Problem(
        task=wanted, simulator=simulator, target=Simulated(task=wanted, simulator=simulator)
    )
    learned = search("ddp")().run(problem, seed=seed)
    seen = attempt(wanted, learned.policy, simulator, rows=ROWS, rng=np.random.default_rng(seed))
    open_loop = seen.command.mean(axis=0)[:, None].repeat(ROWS, axis=1)
    commands = {
        "random commands": chance,
        "its commands without feedback": open_loop,
        "its commands with the sign turned": -open_loop,
        "its commands in another order": rng.permutation(open_loop, axis=0),
    }
    return [
        do_nothing(task_name, body, seed=seed),
        _judge("the learned policy", wanted, seen),
        *(_open_loop(name, wanted, each, seed) for name, each in commands.items()),
    ]


def do_nothing(task_name: str, body: str, *, seed: int) -> Control:
    """Return what commands of zero give."""
    wanted = task(task_name, load(body))
    zero = np.zeros((wanted.samples, ROWS, len(actions_of(wanted.robot))))
    return _open_loop("doing nothing", wanted, zero, seed)


def _open_loop(name: str, wanted: Task, command: Array, seed: int) -> Control:
    """Return the runs of commands (samples, rows, nu) that depend on nothing seen."""
    rng, simulator = np.random.default_rng(seed), wanted.simulator()
    q, v = wanted.start.sample(wanted.robot, simulator.model, command.shape[1], rng)
    moved = run(wanted, simulator, lambda q, v, time: command[round(time / wanted.period)], q, v)
    return _judge(name, wanted, moved)


def _judge(name: str, wanted: Task, moved: Moved) -> Control:
    losses, successes = wanted.loss(moved), wanted.succeeded(moved)
    return Control(
        name=name, losses=tuple(map(float, losses)), successes=tuple(map(bool, successes))
    )


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
