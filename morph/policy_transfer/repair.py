"""The source's simulation repaired: what runs on the target say that it got wrong or left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.latent.parameter_attribution import Explained, explain
from morph.model.latent.run import Run
from morph.model.latent.unknowns import unknowns, with_knobs
from morph.model.missing_force.corrected import Corrected
from morph.model.missing_force.fit import fit
from morph.physics.effect import Effect
from morph.policy_transfer.retask import task_for
from morph.sim.simulator import Simulator
from morph.sim.threads import one_thread
from morph.task.task import Task

MOST_RUNS = 3
"""Latest runs by which a simulation is repaired: more cost time, and tell little more."""

MUCH = 0.02
"""Share of a typical change of speed in a period from which what is left out is learned."""

QUIETEST = 1e-4
"""Least noise that observations are taken to have: without any, rounding would count."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TaskModel:
    """A task with the simulation in which it is thought to take place."""

    task: Task
    """The task for the body as it is thought to be."""
    effects: tuple[Effect, ...]
    """What acts on it beyond the task's own effects."""

    @property
    def simulator(self) -> Simulator:
        """The simulation, compiled anew."""
        return self.task.simulator(self.effects)


@dataclass(frozen=True, kw_only=True, eq=False)
class Repair:
    """A repaired model, and what else the runs allow."""

    model: TaskModel
    """The most probable."""
    explained: Explained
    """What differs, and how surely."""
    task: Task
    """The source's task."""
    learned: Corrected | None = None
    """The force that no name explains, if one was needed, with all else fitted to it."""

    def drawn(self, count: int, rng: np.random.Generator) -> tuple[TaskModel, ...]:
        """Return models that the runs allow as well, drawn by their probability.

        With a learned force there are none: it is as good as its most probable form.
        """
        if self.learned is not None:
            return ()
        result = self.explained.inferred
        points = _within(
            rng.multivariate_normal(result.point, result.covariance, size=count, method="eigh"),
            result.hypothesis.low,
            result.hypothesis.high,
            len(result.hypothesis.knobs),
        )
        return tuple(self._at(point) for point in points)

    def _at(self, point: Array) -> TaskModel:
        hypothesis = self.explained.inferred.hypothesis
        knobs = hypothesis.knobs
        robot = with_knobs(hypothesis.robot, knobs, point[: len(knobs)])
        return _model(self.task, robot, hypothesis.effects_at(point))


def _within(points: Array, low: Array, high: Array, knobs: int) -> Array:
    """Return points whose effects keep to their bounds; knobs have none of use here."""
    kept = points.copy()
    kept[:, knobs:] = np.clip(points[:, knobs:], low[knobs:], high[knobs:])
    return kept


def repaired(
    task: Task,
    runs: Sequence[Run],
    *,
    candidates: Sequence[Effect] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Repair:
    """Return the source's simulation as runs on the target say it should be.

    Args:
        task: The source's task: its body as described, its effects as known.
        runs: What the target showed, the latest last.
        candidates: Effects to look for; default the whole library.
        progress: Is told what is going on.

    Raises:
        DiagnosisError: The body floats, or runs do not fit its clock.
    """
    simulator = task.simulator()
    noise = noise_of(task, simulator)
    with one_thread():
        result = explain(
            task.robot,
            tuple(runs)[-MOST_RUNS:],
            noise,
            step=task.step,
            integrator=simulator.integrator,
            effects=task.effects,
            candidates=candidates,
            progress=progress,
        )
        learned = None if result.unsaid <= MUCH else _learned(result, runs, noise)
    known = result if learned is None else learned
    model = _model(task, known.robot, known.effects)
    return Repair(model=model, explained=result, task=task, learned=learned)


def _learned(result: Explained, runs: Sequence[Run], noise: Array) -> Corrected | None:
    """Return what was found with a force beside it that no name explains; None if it fails."""
    at = result.inferred.transit
    hypothesis = Hypothesis(
        robot=result.robot,
        step=at.hypothesis.step,
        knobs=unknowns(result.robot),
        effects=result.effects,
    )
    latest = tuple(runs)[-MOST_RUNS:]
    try:
        return fit(hypothesis, latest, noise=noise, integrator=at.integrator)
    except DiagnosisError:
        # A delay, say, beside which no force can be learned: names alone must do.
        return None


def noise_of(task: Task, simulator: Simulator) -> Array:
    """Return the standard deviation of each observation, positions then velocities."""
    return np.full(2 * int(simulator.model.nv), max(task.noise, QUIETEST))


def _model(task: Task, robot: Robot, effects: tuple[Effect, ...]) -> TaskModel:
    """Return the task for a body under effects, of which the first are the task's own."""
    own = len(task.effects)
    return TaskModel(
        task=replace(task_for(task, robot), effects=effects[:own]), effects=effects[own:]
    )
