"""Many runs of a task that are stepped from outside, each at its own time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from morph.arrays import Array, Integers, Mask
from morph.errors import SimulationFailed, TaskError
from morph.physics.effect import Effect
from morph.sim.drive import sensed
from morph.task.gym.plant import BatchPlant
from morph.task.gym.spaces import MOST, channels, columns, command_range
from morph.task.moved import Moved
from morph.task.task import UNSTABLE, Task

DRAWN = 16
"""Samples for which a run draws its noise at once: a draw for each sample would take longer."""


@dataclass(frozen=True, kw_only=True)
class PeriodStep:
    """What one control period showed of some runs."""

    reward: Array
    """Less the cost, shape (rows,)."""
    terminated: Mask
    """Which became unstable, shape (rows,)."""
    truncated: Mask
    """Which came to the end of their time, shape (rows,)."""
    costs: dict[str, Array]
    """What each term cost, by its name, shape (rows,) each."""
    success: Mask
    """Which came to the end and reached every goal, shape (rows,)."""


class Runs:
    """Runs of a task; with u_t told at sample t, the reward is -c(x_t, u_t).

    The last reward of a run also holds its last sample, and that of a run that becomes
    unstable all that such a run costs: so the rewards of a run add up to less its loss.

    Args:
        task: What is to be done.
        rows: How many runs.
        effects: What acts on the body beyond what the task says.

    Raises:
        SimulationFailed: The body or its effects cannot run so.
        TaskError: It observes what the state does not hold.
    """

    def __init__(self, task: Task, rows: int, effects: tuple[Effect, ...] = ()) -> None:
        """Compile the body, and start nothing yet."""
        self.task = task
        self._plant = BatchPlant(task, rows, effects)
        model = self._plant.model
        names = channels(task.robot) if task.observes is None else task.observes
        self._columns = columns(task.robot, model, names)
        self._names, self._effects = names, (*task.effects, *effects)
        self._low, self._high = command_range(task.robot)
        self._chance: Sequence[np.random.Generator] = ()
        self._noise = np.zeros((rows, DRAWN, len(names)))
        self._at = np.zeros(rows, dtype=np.int64)
        self._command = np.zeros((rows, model.nu))
        self._spent = np.zeros(rows)
        self._reached = np.ones(rows, dtype=bool)

    @property
    def sizes(self) -> tuple[int, int]:
        """How many numbers are observed, and how many commanded."""
        return len(self._columns), len(self._low)

    def start(self, rows: Integers, chance: Sequence[np.random.Generator]) -> Array:
        """Start some runs anew; return what is seen of them, shape (rows, observations).

        Args:
            rows: Which.
            chance: The chance of every run, also of those that go on.
        """
        self._chance = chance
        model = self._plant.model
        drawn = np.stack([chance[row].standard_normal((2, model.nv)) for row in rows], axis=1)
        position, velocity = self.task.start.spread_by(self.task.robot, model, drawn)
        self._plant.start(rows, position, velocity)
        self._at[rows], self._command[rows], self._spent[rows] = 0, 0.0, 0.0
        self._reached[rows] = True
        return self.seen(rows)

    def seen(self, rows: Integers) -> Array:
        """Return what is seen of some runs, to be asked once a sample, (rows, observations)."""
        state = np.concatenate([self._plant.position[rows], self._plant.velocity[rows]], axis=1)
        reading = state[:, self._columns]
        for at, channel in enumerate(self._names):
            reading[:, at] = sensed(self._effects, channel, reading[:, at])
        if self.task.noise > 0.0:
            age = self._at[rows] % DRAWN
            for row in rows[age == 0]:
                self._chance[row].standard_normal(out=self._noise[row])
            reading += self.task.noise * self._noise[rows, age]
        return np.asarray(np.clip(reading, -MOST, MOST))

    def step(self, rows: Integers, action: ArrayLike) -> PeriodStep:
        """Let some runs go on for a control period.

        Args:
            rows: Which.
            action: From -1 to 1 between the least and the greatest command; (rows, actuators).

        Raises:
            SimulationFailed: An action is no number, or MuJoCo refuses to step.
            TaskError: A cost is no number.
        """
        self._command[rows] = self._commands(rows, action)
        costs = self._costs(rows)
        self._plant.advance(rows, self._at[rows], self._command[rows])
        self._at[rows] += 1
        unstable = self._plant.unstable[rows]
        ended = (self._at[rows] == self.task.samples - 1) & ~unstable
        if ended.any():
            for name, cost in self._costs(rows[ended]).items():
                costs[name][ended] += cost
        cost = np.sum([np.zeros(len(rows)), *costs.values()], axis=0)
        cost[unstable] = UNSTABLE - self._spent[rows[unstable]]
        self._spent[rows] += cost
        return PeriodStep(
            reward=-cost,
            terminated=unstable,
            truncated=ended,
            costs=costs,
            success=ended & self._reached[rows],
        )

    def _commands(self, rows: Integers, action: ArrayLike) -> Array:
        command = np.asarray(action, dtype=float)
        if command.shape != (len(rows), len(self._low)) or not np.isfinite(command).all():
            raise SimulationFailed(
                f"an action is not a finite number for each of {len(self._low)} actuators",
                where=f"an environment of {self.task.robot.name}",
                fix="give numbers from -1 to 1, in the order of the robot's actuators",
            )
        middle, half = (self._low + self._high) / 2.0, (self._high - self._low) / 2.0
        return np.asarray(middle + half * np.clip(command, -1.0, 1.0))

    def _costs(self, rows: Integers) -> dict[str, Array]:
        """Return what each term costs at the sample where each run is; note goals missed."""
        costs = {term.name: np.zeros(len(rows)) for term in self.task.terms}
        for at in np.unique(self._at[rows]):
            here = self._at[rows] == at
            moved = self._moved(rows[here], int(at))
            last = at == self.task.samples - 1
            for term in self.task.terms:
                if last or not term.last_only:
                    costs[term.name][here] = self._finite(term.name, term.cost(moved)[:, 0])
            for goal in self.task.goals:
                if moved.time[0] >= self.task.horizon - goal.last - 1e-9:
                    self._reached[rows[here]] &= goal.reached(moved)
        return costs

    def _moved(self, rows: Integers, at: int) -> Moved:
        """Return the sample where some runs are, all of them at the same time."""
        return Moved(
            robot=self.task.robot,
            model=self._plant.model,
            time=np.array([at * self.task.period]),
            position=self._plant.position[rows][:, None],
            velocity=self._plant.velocity[rows][:, None],
            command=self._command[rows][:, None],
        )

    def _finite(self, name: str, cost: Array) -> Array:
        if not np.isfinite(cost).all():
            raise TaskError(
                f"term {name!r} is no number",
                where=f"task {self.task.name} of {self.task.robot.name}",
                fix="check its quantity and the states that it was given",
            )
        return cost
