"""What a run took and what it was worth: energy, torque margin and cost, so far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from morph.app.picture.times import nearest_samples
from morph.app.viewer.compare.forces import Forces
from morph.app.viewer.compare.run import SimulatedRun, at_control_times
from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.task.task import Task

ENERGY, MARGIN, COST = "energy (J)", "torque margin (%)", "cost"
"""Names of the series."""

NOTHING = 1e-15
"""J; less work in a step than this is rounding."""


@dataclass(frozen=True, kw_only=True)
class TaskVerdict:
    """Whether a body did its task."""

    reached: tuple[str, ...]
    """The goals that it reached."""
    missed: tuple[str, ...]
    """Those that it did not."""

    @property
    def words(self) -> str:
        """It in two words."""
        return "missed" if self.missed else "reached"


def energy(run: SimulatedRun, forces: Forces) -> Array:
    """Return the mechanical work of the motors so far, J, shape (samples,).

    E = sum over steps and joints of |torque * way|; what a motor brakes counts as what it
    drives, as no motor of a robot gets its energy back. A torque is taken to last one step.
    """
    ways = np.diff(run.position[:, [drive.place for drive in forces.drives]], axis=0)
    work = np.abs(forces.effort[:-1] * ways).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(np.where(work < NOTHING, 0.0, work))])


def margin(efforts: Array, limits: Array) -> Array:
    """Return the least share of a motor's limit that was left so far, shape (samples,).

    1 - |effort| / limit of the motor that is nearest to its limit; NaN if none has a limit.

    Args:
        efforts: N m or N, shape (samples, motors).
        limits: Likewise, shape (motors,); NaN for none.
    """
    known = np.isfinite(limits) & (limits > 0.0)
    if not known.any():
        return np.full(len(efforts), np.nan)
    left = 1.0 - (np.abs(efforts[:, known]) / limits[known]).max(axis=1)
    return np.asarray(np.minimum.accumulate(left))


def cost(task: Task, run: SimulatedRun) -> Array:
    """Return what the task's terms cost so far at each sample, shape (samples,).

    A cost falls due at a control time, and then stays.
    """
    moved = at_control_times(task, run)
    total = np.cumsum(np.sum(list(task.costs(moved).values()), axis=0))
    due = np.searchsorted(moved.time, run.time + 1e-9, side="right") - 1
    return np.asarray(total[due])


def verdict(task: Task, run: SimulatedRun) -> TaskVerdict | None:
    """Return which goals a run reached; None if it ended before the task's horizon."""
    moved = at_control_times(task, run)
    if run.why or len(moved.time) < task.samples:
        return None
    fine = {goal.name: bool(goal.reached(moved)) for goal in task.goals}
    return TaskVerdict(
        reached=tuple(name for name, reached in fine.items() if reached),
        missed=tuple(name for name, reached in fine.items() if not reached),
    )


def series(task: Task, run: SimulatedRun, forces: Forces) -> Mapping[str, Array]:
    """Return all of these in each picture, by their names."""
    pictures = nearest_samples(run.time, RATE)
    limits = np.array([np.nan if each.limit is None else each.limit for each in forces.drives])
    return {
        ENERGY: energy(run, forces)[pictures],
        MARGIN: 100.0 * margin(forces.effort, limits)[pictures],
        COST: cost(task, run)[pictures],
    }
