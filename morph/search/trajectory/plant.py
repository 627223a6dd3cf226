"""A simulated body as optimal control sees it: one control period after another, many at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from morph.arrays import Array
from morph.errors import SimulationFailed
from morph.physics.fluid.settle import batches
from morph.policy.policy import actions_of
from morph.search.trajectory.tangent import apart
from morph.sim.rollout import Variant, quiet, rollout
from morph.sim.simulator import Simulator
from morph.sim.threads import batch_threads

HUGE = 1e6
"""Position or velocity, in its unit, from which a row counts as unstable."""

DRY = (
    "coulomb_friction",
    "stribeck_friction",
    "load_dependent_friction",
    "position_dependent_friction",
)
"""Effects that can hold a joint still."""

MOST_KEPT = 8
"""Batches of different sizes that a plant keeps, as making one takes milliseconds."""


class Stepped(ABC):
    """What goes from one control period to the next, many rows at once: a body, or a dream of one.

    Its state is a position and a velocity: x = (q, v), of 2 nv numbers in the tangent space.
    """

    model: Any
    """The compiled `mujoco.MjModel`."""

    @abstractmethod
    def advance(self, position: Array, velocity: Array, command: Array) -> tuple[Array, Array]:
        """Return positions (rows, nq) and velocities (rows, nv) one control period later.

        A row that becomes unstable is NaN from then on.
        """

    def rollout(self, position: Array, velocity: Array, command: Array) -> tuple[Array, Array]:
        """Return all states under commands that nothing corrects, the first included.

        Args:
            position: Where each row starts, shape (rows, nq).
            velocity: How fast, shape (rows, nv).
            command: What it is told, shape (rows, periods, nu).

        Returns:
            Positions (rows, periods + 1, nq) and velocities (rows, periods + 1, nv).
        """
        rows, periods = command.shape[:2]
        q = np.empty((rows, periods + 1, self.model.nq))
        v = np.empty((rows, periods + 1, self.model.nv))
        q[:, 0], v[:, 0] = position, velocity
        for at in range(periods):
            q[:, at + 1], v[:, at + 1] = self.advance(q[:, at], v[:, at], command[:, at])
        return q, v

    @property
    def sliding(self) -> Stepped:
        """What slopes are taken of: this, unless dry friction may hold a joint of it."""
        return self

    def off(self, q: Array, v: Array, at_q: Array, at_v: Array, *, wrapped: bool = False) -> Array:
        """Return how far states are from others in the tangent space, shape (..., 2 nv)."""
        place = apart(self.model, q, at_q, wrapped=wrapped)
        return np.concatenate(np.broadcast_arrays(place, v - at_v), axis=-1)


class Plant(Stepped):
    """A body whose commands are held for a control period, through several steps of physics.

    Args:
        simulator: The body under its effects.
        period: How long a command is held, s: a multiple of the simulator's step.

    Raises:
        SimulationFailed: The period is no such multiple, or actuators have states of their own.
    """

    def __init__(self, simulator: Simulator, period: float) -> None:
        """Find how many steps a period has, and the bounds of the commands."""
        model: Any = simulator.model
        steps = period / simulator.step
        where = f"a plan for {simulator.robot.name}"
        if not (steps > 0.5 and abs(steps - round(steps)) < 1e-6):
            raise SimulationFailed(
                f"a control period of {period:g} s is no multiple of a step, {simulator.step:g} s",
                where=where,
                fix="give a period of one step or more",
            )
        late = [effect.label for effect in simulator.effects if effect.remembers]
        if late:
            raise SimulationFailed(
                f"{', '.join(late)} remembers the past, and a plan knows positions and "
                "velocities alone",
                where=where,
                fix="leave it out, or take a search that tries policies, such as cmaes",
            )
        if model.na:
            raise SimulationFailed(
                f"{model.na} numbers are states of actuators, and a plan knows positions and "
                "velocities alone",
                where=where,
                fix="leave out the effects on actuators, or search without a plan",
            )
        self.robot, self.model, self.period = simulator.robot, model, period
        self.substeps = round(steps)
        self.low, self.high = bounds_of(simulator)
        self._variant = Variant(model=model, effects=simulator.effects)
        self._slow = any(each.stepped for each in simulator.effects) or not batches(model)
        self._remembers = bool(model.neq or model.jnt_limited.any() or may_touch(model))
        self._remembers |= bool(model.dof_frictionloss.any() or model.tendon_limited.any())
        self._kept: dict[int, Batch] = {}
        self.simulator = simulator

    @cached_property
    def sliding(self) -> Plant:
        """The same body without dry friction, which slopes are taken of.

        A joint that friction holds has no slope at all: neither feedback nor a better plan would
        be found there. Once it slides, friction is a constant force, and slopes are these.
        """
        known = self.simulator
        wet = tuple(each for each in known.effects if each.name not in DRY)
        if len(wet) == len(known.effects) and not self.model.dof_frictionloss.any():
            return self
        free = Simulator(known.robot, wet, step=known.step, integrator=known.integrator)
        free.model.dof_frictionloss[:] = 0.0
        return Plant(free, self.period)

    def advance(self, position: Array, velocity: Array, command: Array) -> tuple[Array, Array]:
        """Return positions (rows, nq) and velocities (rows, nv) one control period later.

        A row that becomes unstable is NaN from then on.
        """
        if self._slow:
            steps = np.repeat(command[:, None], self.substeps, axis=1)
            which = np.zeros(len(command), dtype=np.int64)
            q, v = rollout([self._variant], which, position, velocity, steps)
            return q[:, -1], v[:, -1]
        batch = self._batch(len(command))
        # What a row found last time is where a solver of constraints begins; a count of warnings
        # stays. Without either there is nothing to forget, and a reset costs a seventh of it all.
        if self._remembers or np.asarray(batch.warning[..., 1]).any():
            batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        fine = np.asarray(np.isfinite(position).all(-1) & np.isfinite(velocity).all(-1))
        good = fine[:, None]
        batch.bind("qpos")[:] = np.where(good, position, self.model.qpos0)
        batch.bind("qvel")[:] = np.where(good, velocity, 0.0)
        batch.bind("ctrl")[:] = np.where(good, command, 0.0)
        try:
            with quiet():
                batch.step(nstep=self.substeps)
        except SimulationError as error:
            raise SimulationFailed(
                f"MuJoCo stopped: {error}",
                where=f"a plan for {self.robot.name}",
                fix="check the robot's masses and inertias, or take a smaller step",
            ) from error
        fine = fine & ~np.asarray(batch.warning[..., 1]).reshape(len(command), -1).any(axis=1)
        q, v = batch.bind("qpos"), batch.bind("qvel")
        # What MuJoCo still bears at such speeds is no motion that a plan could use.
        fine &= (np.abs(q) < HUGE).all(axis=1) & (np.abs(v) < HUGE).all(axis=1)
        good = fine[:, None]
        return np.where(good, q, np.nan), np.where(good, v, np.nan)

    def _batch(self, rows: int) -> Batch:
        if rows not in self._kept:
            if len(self._kept) >= MOST_KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[rows] = Batch(self.model, rows, batch_threads(rows, worth=17))
            self._kept[rows].reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        return self._kept[rows]


def may_touch(model: Any) -> bool:
    """Return whether any two shapes of a model may touch."""
    return bool(model.npair or (model.geom_contype.any() and model.geom_conaffinity.any()))


def bounds_of(simulator: Simulator) -> tuple[Array, Array]:
    """Return the least and the greatest command of each actuator, shape (nu,) both.

    What the robot says and what its description clamps both hold.
    """
    actions = actions_of(simulator.robot)
    low = np.array([each.low for each in actions])
    high = np.array([each.high for each in actions])
    limited = simulator.model.actuator_ctrllimited.astype(bool)
    limits = simulator.model.actuator_ctrlrange
    return (
        np.where(limited, np.maximum(low, limits[:, 0]), low),
        np.where(limited, np.minimum(high, limits[:, 1]), high),
    )
