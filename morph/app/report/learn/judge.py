"""How good a policy is: runs that the search never saw, beside what it takes to do no better."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Mask
from morph.policy.policy import Policy, actions_of
from morph.search.evaluate import ROWS, Score, attempt
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.task import Task

JUDGING = 2**31 - 1
"""Names the chance of these runs, so that it is that of no trial."""

FEWEST = 10
"""Runs that judge the heaviest body."""

MOST_WORK = 2e7
"""Velocity coordinates times steps of simulation that judging may take, about 20 s of a core.

A heavy body is judged by fewer runs. Their number follows from the task and never from a clock, so
that a busy machine reports the same figures.
"""

CONTROL_WORK = 1e6
"""The same for each of the controls."""

WILD = 3.0
"""Bound of a random command where nothing else bounds it, in its unit: half a turn, nearly."""


@dataclass(frozen=True, kw_only=True)
class JudgedPolicy:
    """What a policy did over many runs, and what two that know nothing did over the same."""

    moved: Moved
    """The runs, (rows, samples, ...)."""
    loss: Array
    """What each cost, shape (rows,)."""
    success: Mask
    """Which reached every goal, shape (rows,)."""
    terms: Mapping[str, float]
    """What each term cost, the mean over the runs."""
    goals: Mapping[str, float]
    """The share of the runs that reached each goal."""
    controls: Mapping[str, Score]
    """From the first of the same starts. `nothing`: every command zero, or what is nearest to it.
    `random`: drawn anew each control period."""

    @property
    def rows(self) -> int:
        """How many runs there are."""
        return len(self.loss)

    @property
    def share(self) -> float:
        """The share of the runs that reached every goal."""
        return float(self.success.mean())

    @property
    def typical(self) -> int:
        """The run whose loss is nearest to the median."""
        return int(np.argmin(np.abs(self.loss - np.median(self.loss))))


def judge(task: Task, policy: Policy, simulator: Simulator, seed: int) -> JudgedPolicy:
    """Return how a policy does from drawn starts, seen through the task's noise.

    Raises:
        TaskError: A cost is no number.
        SimulationFailed: The simulation cannot run in a closed loop.
    """
    rows = int(np.clip(MOST_WORK / _work(task, simulator), FEWEST, ROWS))
    moved = attempt(task, policy, simulator, rows=rows, rng=_chance(seed))
    return JudgedPolicy(
        moved=moved,
        loss=task.loss(moved),
        success=task.succeeded(moved),
        terms={name: float(cost.sum(-1).mean()) for name, cost in task.costs(moved).items()},
        goals={goal.name: float(goal.reached(moved).mean()) for goal in task.goals},
        controls=_controls(task, simulator, rows, seed),
    )


def _work(task: Task, simulator: Simulator) -> float:
    """Return the velocity coordinates times steps of one run."""
    return float(simulator.model.nv * task.horizon / simulator.model.opt.timestep)


def _chance(seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, JUDGING])


def _controls(task: Task, simulator: Simulator, rows: int, seed: int) -> dict[str, Score]:
    """Return how doing nothing and random commands do from the first of the very same starts.

    A heavy body does so from fewer of them: thrown about it takes longest to simulate, and what
    knows nothing differs from a policy by more than the rest could show.
    """
    rng = _chance(seed)
    few = int(np.clip(CONTROL_WORK / _work(task, simulator), FEWEST, rows))
    starts = task.start.sample(task.robot, simulator.model, rows, rng)
    position, velocity = (each[:few] for each in starts)
    bounds = np.array([(each.low, each.high) for each in actions_of(task.robot)])
    # A bound that is none would command a million radians.
    low, high = np.where(np.abs(bounds) < 1e6, bounds, np.sign(bounds) * WILD).T

    def nothing(q: Array, v: Array, now: float) -> Array:
        return np.tile(np.clip(0.0, low, high), (few, 1))

    def chance(q: Array, v: Array, now: float) -> Array:
        return rng.uniform(low, high, (few, len(low)))

    runs = {
        name: run(task, simulator, act, position, velocity)
        for name, act in (("nothing", nothing), ("random", chance))
    }
    return {
        name: Score(loss=task.loss(moved), success=task.succeeded(moved))
        for name, moved in runs.items()
    }
