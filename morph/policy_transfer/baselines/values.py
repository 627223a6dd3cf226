"""Baseline: the source's value function with the target's learned dynamics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.policy_transfer.baselines.baseline import NextStep
from morph.policy_transfer.baselines.learner import Learner, periods
from morph.policy_transfer.baselines.source import Source
from morph.search.evaluate import attempt
from morph.search.learned_dynamics.learned_body import Dream, known
from morph.search.learned_dynamics.memory import SearchCheckpoint
from morph.search.learned_dynamics.plan_choice import Plans
from morph.search.plan.terminal_controller import aided, grounded
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant


@dataclass(frozen=True, kw_only=True, eq=False)
class Worth:
    """The source's run and what leaving it costs: 1/2 dx' V_t dx from each sample on."""

    position: Array
    """Where the source is, shape (samples, nv)."""
    velocity: Array
    """How fast, shape (samples, nv)."""
    command: Array
    """What it is told, shape (samples - 1, nu)."""
    value: Array
    """V, shape (samples, 2 nv, 2 nv)."""
    effort: Array
    """R, what commands cost, shape (nu, nu)."""
    hold: tuple[Array, Array, Array]
    """State of rest, its command, and the regulator's gain there."""


@dataclass(frozen=True, kw_only=True)
class Values(Learner):
    """Looks one period ahead in the learned target, and from there trusts the source's values.

    With x the source's run, u its commands, f the target as learned, A and B its slopes there,
    and V what the source's plan says that a deviation costs from then on, the command

        u_t + du,  du = -inv(R + B' V B) B' V (f(x_t, u_t) - x_{t+1} + A dx),

    makes 1/2 du' R du + 1/2 dx' V dx of the next period least.

    Source: that values are carried, Taylor, Stone and Liu 2007, Transfer learning via inter-task
    mappings for temporal difference learning, JMLR 8; the quadratic step, Tassa, Mansard and
    Todorov 2014, eq. 5.
    """

    name: ClassVar[str] = "values carried over"

    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return what runs of the target say."""
        return fit(periods(memory.experience, settings, source.task), settings, memory.logs)

    def planned(
        self, source: Source, learned: Jointed, memory: SearchCheckpoint, rng: np.random.Generator
    ) -> NextStep:
        """Return the source's run, with the feedback that is best on the target by its values."""
        dream = Dream(source.task, *known(source.task), learned)
        plan = ahead(worth_of(source), dream.plant)
        return NextStep(
            policy=plan.track(0, source.task),
            plan=plan,
            logs=learned.logs.numpy(),
            note="a period ahead in the learned target, then by the source's values",
        )


def worth_of(source: Source) -> Worth:
    """Return the source's run without noise, and its values."""
    task, simulator = source.task, source.target.simulator
    moved = attempt(task, source.policy, simulator, rows=1, rng=None)
    q, v, u = moved.position[0], moved.velocity[0], moved.command[0, :-1]
    ground = grounded(task, simulator, margin=0.0, rng=np.random.default_rng(0))
    plant, regulator = ground.plant, ground.regulator
    A, B = linearise(plant, q[:-1], v[:-1], u)
    here = aided(ground.cost, q[None], v[None], u[None]).xx[0]
    half = 0.5 * (plant.high - plant.low)
    R = regulator.effort * np.diag(half**-2.0)
    value = np.empty_like(here)
    value[-1] = here[-1] + regulator.worth
    for at in reversed(range(len(u))):
        towards = B[at].T @ value[at + 1]
        gain = -np.linalg.solve(R + towards @ B[at], towards @ A[at])
        result = here[at] + A[at].T @ value[at + 1] @ (A[at] + B[at] @ gain)
        value[at] = 0.5 * (result + result.T)
    still = ground.still
    rest = np.concatenate([still.position, still.velocity])
    # The state of rest, so many turns on that the run's end is near.
    apart = plant.off(q[-1], v[-1], still.position, still.velocity, wrapped=True)
    rest[: plant.model.nv] = q[-1] - apart[: plant.model.nv]
    return Worth(
        position=q,
        velocity=v,
        command=u,
        value=value,
        effort=R,
        hold=(rest, still.command, regulator.gain),
    )


def ahead(worth: Worth, plant: Plant) -> Plans:
    """Return the source's run with the feedback that is best a period ahead in a learned body."""
    q, v, u = worth.position, worth.velocity, worth.command
    A, B = linearise(plant, q[:-1], v[:-1], u)
    went = plant.off(*plant.advance(q[:-1], v[:-1], u), q[1:], v[1:])
    towards = np.swapaxes(B, -1, -2) @ worth.value[1:]
    law = -np.linalg.solve(worth.effort + towards @ B, towards)
    rest, stay, hold = worth.hold
    state = np.concatenate([np.concatenate([q, v], axis=1)[:-1], rest[None]])
    return Plans(
        state=state[None],
        command=np.concatenate([u + (law @ went[..., None])[..., 0], stay[None]])[None],
        gain=np.concatenate([law @ A, hold[None]])[None],
    )
