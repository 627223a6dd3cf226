"""Initial trajectories to a state of rest: bang-bang commands and straight paths."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Integers
from morph.search.plan.bang_bang import Switches, drawn
from morph.search.regulator.lqr import Regulator
from morph.search.regulator.rest import Rest, driven, off_rest, unlimited
from morph.search.trajectory.backward import FeedbackLaw, backward
from morph.search.trajectory.cost import Quadratic, TaskCost
from morph.search.trajectory.ddp import Trajectories, follow
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import moved_by, turning

ELITE = 32
"""Rows that are kept from one round of sampling to the next."""

SPREADS = (0.15, 0.08, 0.04)
"""How far switching times are varied, round after round."""

STRAINED = 1.5
"""Command that the regulator may want beyond its bounds, in bounds, where it takes over."""

SWING_SHARE = 0.5
"""Share of the horizon in which a swing must reach the regulator."""

LENGTHS = (0.2, 0.3, 0.45, 0.65)
"""How long a straight path takes, as shares of the horizon."""

MOST_PATHS = 64
"""Straight paths that are tried: each hinge may go either way round."""


@dataclass(frozen=True, kw_only=True)
class SeedInputs:
    """What every guess stands on."""

    cost: TaskCost
    """The cost, with its body and task."""
    still: Rest
    """Where to end."""
    regulator: Regulator
    """What holds it there."""
    begin: tuple[Array, Array]
    """The state to begin in: (nq,) and (nv,)."""
    quick: Plant
    """The body in coarser steps, in which guesses are drawn."""
    margin: float
    """Share of each command's range that is left free at both its ends."""

    @property
    def plant(self) -> Plant:
        """The body."""
        return self.cost.plant

    @property
    def periods(self) -> int:
        """Control periods of the horizon."""
        return self.cost.task.samples - 1

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The bounds of the commands within the margin."""
        spare = self.margin * 0.5 * (self.plant.high - self.plant.low)
        return self.plant.low + spare, self.plant.high - spare

    def starts(self, rows: int) -> tuple[Array, Array]:
        """Return the state to begin in, once for each row."""
        return np.tile(self.begin[0], (rows, 1)), np.tile(self.begin[1], (rows, 1))


def swung(
    ground: SeedInputs,
    rows: int,
    keep: int,
    rng: np.random.Generator,
    *,
    share: float = SWING_SHARE,
) -> Trajectories:
    """Return the best bang-bang swings that end in the regulator's reach, and it takes over there.

    Switching times are drawn, and those of the best are varied, less each round. A swing is
    judged where it comes closest: by what it has cost up to there and what the regulator's
    cost-to-go says of the rest; the most promising are run to the end. All but the last round
    are run in coarser steps.

    Args:
        ground: What they stand on.
        rows: How many are drawn; a quarter as many in each later round.
        keep: How many are given back.
        rng: Chance.
        share: Share of the horizon within which a swing must reach the regulator.
    """
    periods = max(2, round(share * ground.periods))
    period = ground.plant.period

    def commands(switches: Switches) -> Array:
        return switches.commands(*ground.bounds, period=period, periods=periods)

    guesses = drawn(rows, ground.plant.model.nu, slowest_swing(ground), rng)
    for spread in SPREADS:
        order, _ = ranked(ground, ground.quick, commands(guesses))
        best = guesses.rows(order[:ELITE])
        varied = best.rows(rng.integers(0, len(best.level), rows // 4)).jittered(spread, rng)
        guesses = Switches(
            duration=np.concatenate([best.duration, varied.duration]),
            level=np.concatenate([best.level, varied.level]),
        )
    _, runs = ranked(ground, ground.plant, commands(guesses))
    return _best(ground, runs, keep)


def ranked(ground: SeedInputs, plant: Plant, command: Array) -> tuple[Integers, Trajectories]:
    """Return the numbers of the most promising commands, the best first, and their runs.

    A cost-to-go promises too much far from rest, so the regulator shows what it can catch.

    Args:
        ground: What they stand on.
        plant: The body that they are run on.
        command: Shape (rows, periods, nu); the horizon may be longer.
    """
    score, reach = _judged(ground, plant, command)
    order = np.argsort(score)[: 2 * ELITE]
    runs = taken_over(ground, plant, command[order], reach[order])
    best = np.argsort(runs.cost)
    return order[best], runs.rows(best)


def slowest_swing(ground: SeedInputs) -> float:
    """Return the period of the slowest oscillation about the start, s; a third of the run if none.

    x' = A x with eigenvalues exp(+-i angle), and angle < pi, oscillates with 2 pi period / angle.
    """
    q, v = ground.begin
    A, _ = linearise(ground.plant, q, v, np.zeros(ground.plant.model.nu))
    angles = np.abs(np.angle(np.linalg.eigvals(A)))
    horizon = ground.periods * ground.plant.period
    angles = angles[angles > 2.0 * np.pi * ground.plant.period / horizon]
    return 2.0 * np.pi * ground.plant.period / float(angles.min()) if len(angles) else horizon / 3.0


def _judged(ground: SeedInputs, plant: Plant, command: Array) -> tuple[Array, Integers]:
    """Return what swings may cost, (rows,), and after which period the regulator takes over."""
    cost = ground.cost
    q, v = plant.rollout(*ground.starts(len(command)), command)
    fine = np.isfinite(q).all((1, 2)) & np.isfinite(v).all((1, 2))
    q[~fine], v[~fine] = ground.begin
    each = sum(cost.task.costs(cost.moved(q, v, command)).values(), np.zeros(q.shape[:2]))
    spent = np.cumsum(each, axis=1) - each
    dx = off_rest(plant, ground.still, q, v)
    worth = 0.5 * np.einsum("rki,ij,rkj->rk", dx, ground.regulator.worth, dx)
    requested = dx @ ground.regulator.gain.T + ground.still.command
    middle, half = 0.5 * (plant.high + plant.low), 0.5 * (plant.high - plant.low)
    strain = np.maximum(np.abs((requested - middle) / half).max(-1) - STRAINED, 0.0)
    # A regulator that must strain fails before its cost-to-go says so.
    total = spent + worth * (1.0 + strain) + 10.0 * strain
    total[~fine] = np.inf
    return total.min(axis=1), total.argmin(axis=1)


def taken_over(ground: SeedInputs, plant: Plant, command: Array, reach: Integers) -> Trajectories:
    """Return runs that follow commands through so many periods, and then the regulator."""
    still, low, high = ground.still, *ground.bounds
    rows = len(command)
    q = np.empty((rows, ground.periods + 1, plant.model.nq))
    v = np.empty((rows, ground.periods + 1, plant.model.nv))
    u = np.empty((rows, ground.periods, plant.model.nu))
    q[:, 0], v[:, 0] = ground.starts(rows)
    for at in range(ground.periods):
        back = still.command + off_rest(plant, still, q[:, at], v[:, at]) @ ground.regulator.gain.T
        given = command[:, min(at, command.shape[1] - 1)]
        u[:, at] = np.clip(np.where((at < reach)[:, None], given, back), low, high)
        u[:, at] = np.where(np.isfinite(u[:, at]), u[:, at], 0.0)
        q[:, at + 1], v[:, at + 1] = plant.advance(q[:, at], v[:, at], u[:, at])
    return costed(ground, q, v, u)


def costed(ground: SeedInputs, q: Array, v: Array, u: Array) -> Trajectories:
    """Return trajectories with what they cost."""
    return Trajectories(position=q, velocity=v, command=u, cost=ground.cost.values(q, v, u).sum(-1))


def _best(ground: SeedInputs, runs: Trajectories, keep: int) -> Trajectories:
    return runs.rows(np.argsort(runs.cost)[:keep])


def led(ground: SeedInputs, keep: int) -> Trajectories:
    """Return the best runs along straight paths from the start to the rest, with feedback.

    Every joint goes from where it is to where it should be, as smoothly as it can (a minimum of
    jerk), sooner or later and either way round; inverse dynamics says with what commands, and a
    feedback along the path mends what bounds and the holding of commands leave over. It suits
    bodies that have an actuator on every joint, and does no harm to others.
    """
    plant, periods = ground.plant, ground.periods
    paths = _paths(ground)
    q = np.concatenate([each[0] for each in paths])
    v = np.concatenate([each[1] for each in paths])
    wanted = np.concatenate([each[2] for each in paths])
    low, high = ground.bounds
    u = np.clip(wanted, low, high)
    rows, n, m = len(q), 2 * plant.model.nv, plant.model.nu
    A, B = linearise(plant, q[:, :-1], v[:, :-1], u)
    half = 0.5 * (plant.high - plant.low)
    flat = Quadratic(
        x=np.zeros((rows, periods + 1, n)),
        u=np.zeros((rows, periods + 1, m)),
        xx=np.tile(np.eye(n), (rows, periods + 1, 1, 1)),
        uu=np.tile(ground.regulator.effort * np.diag(half**-2), (rows, periods + 1, 1, 1)),
        ux=np.zeros((rows, periods + 1, m, n)),
    )
    wide = np.full(u.shape, np.inf)
    law = backward(A, B, flat, -wide, wide, np.zeros((rows, m)))
    still = FeedbackLaw(change=np.zeros_like(u), gain=law.gain, promised=law.promised)
    plan = Trajectories(position=q, velocity=v, command=u, cost=np.zeros(rows))
    edge = np.broadcast_to(low, u.shape), np.broadcast_to(high, u.shape)
    run = follow(plant, plan, still, *edge)
    fine = np.isfinite(run.position).all((1, 2)) & np.isfinite(run.velocity).all((1, 2))
    run = run.rows(np.flatnonzero(fine))
    return _best(ground, costed(ground, run.position, run.velocity, run.command), keep)


def _paths(ground: SeedInputs) -> list[tuple[Array, Array, Array]]:
    """Return positions, velocities and commands of straight paths, each with a row of its own."""
    plant = ground.plant
    model = plant.model
    q0 = ground.begin[0]
    way = -off_rest(plant, ground.still, q0, ground.begin[1])[: model.nv]
    choices = [
        (0.0,) if not turns or abs(step) < 1e-3 else (0.0, -2.0 * np.pi * np.sign(step))
        for turns, step in zip(turning(model), way, strict=True)
    ]
    time = np.arange(ground.periods + 1) / ground.periods
    results = []
    free = unlimited(model)
    data = mujoco.MjData(free)
    for turn in list(product(*choices))[: MOST_PATHS // len(LENGTHS)]:
        for length in LENGTHS:
            s = np.clip(time / length, 0.0, 1.0)
            along = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
            speed = 30.0 * s**2 * (1.0 - s) ** 2 / (length * ground.periods * plant.period)
            move = way + np.array(turn)
            q = moved_by(model, q0, along[:, None] * move)
            v = speed[:, None] * move
            results.append((q[None], v[None], _inverse(ground, free, data, q, v)[None]))
    return results


def _inverse(ground: SeedInputs, model: Any, data: Any, q: Array, v: Array) -> Array:
    """Return the commands that best move a body along states, shape (periods, nu)."""
    period = ground.plant.period
    command = np.empty((len(q) - 1, ground.plant.model.nu))
    for at in range(len(command)):
        acceleration = (v[at + 1] - v[at]) / period
        middle = 0.5 * (v[at] + v[at + 1])
        place = moved_by(ground.plant.model, q[at], 0.5 * period * middle)
        command[at], _ = driven(model, data, place, middle, acceleration)
    return command
