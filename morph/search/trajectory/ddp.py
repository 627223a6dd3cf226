"""Differential dynamic programming with bounded commands, on many trajectories at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array, Integers
from morph.search.trajectory.backward import FeedbackLaw, backward
from morph.search.trajectory.cost import TaskCost
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant

LENGTHS = (1.0, 0.5, 0.2, 0.05)
"""Shares of the change that are tried, all at once."""

DAMPING = 1e-3
"""Curvature of a command's range that is added first, as a share of the cost's unit."""

MOST_DAMPING = 1e6
"""Damping at which a trajectory counts as arrived."""


@dataclass(frozen=True, kw_only=True)
class Trajectories:
    """States and commands of many runs, and what they cost."""

    position: Array
    """Shape (rows, periods + 1, nq)."""
    velocity: Array
    """Shape (rows, periods + 1, nv)."""
    command: Array
    """Shape (rows, periods, nu)."""
    cost: Array
    """Shape (rows,)."""

    def rows(self, which: Integers) -> Trajectories:
        """Return some of them."""
        return Trajectories(**{name: value[which] for name, value in vars(self).items()})


def ddp(
    plant: Plant,
    cost: TaskCost,
    start: Trajectories,
    *,
    margin: Array | float = 0.0,
    most: int = 30,
    enough: float = 1e-3,
) -> Trajectories:
    """Return trajectories improved until none gets better by a share of `enough` in a step.

    Args:
        plant: The body.
        cost: What is to become least.
        start: Trajectories of the body, one a row.
        margin: Share of each command's range that is left free at both of its ends, for the
            feedback to act in; one number, or one a row.
        most: Steps after which it ends in any case.
        enough: The improvement, as a share of the cost, that counts as none.
    """
    rows = len(start.command)
    half = 0.5 * (plant.high - plant.low)
    spare = np.broadcast_to(np.asarray(margin, dtype=float), (rows,))[:, None, None] * half
    low, high = plant.low + spare, plant.high - spare
    now = restarted(plant, cost, start, np.clip(start.command, low, high))
    damping = np.full(rows, DAMPING)
    busy = np.ones(rows, dtype=bool)
    for _ in range(most):
        at = np.flatnonzero(busy)
        part = now.rows(at)
        law = law_of(plant, cost, part, low[at], high[at], damping[at])
        tried = _tried(plant, cost, part, law, low[at], high[at])
        fell = part.cost - tried.cost
        better = fell > 0.0
        for name, value in vars(tried).items():
            getattr(now, name)[at[better]] = value[better]
        damping[at] *= np.where(better, 0.3, 10.0)
        small = fell <= enough * np.abs(part.cost)
        lost = ~better & ((damping[at] > MOST_DAMPING) | (law.promised <= enough * part.cost))
        busy[at] = ~((better & small) | lost)
        if not busy.any():
            break
    return now


def law_of(
    plant: Plant, cost: TaskCost, now: Trajectories, low: Array, high: Array, damping: Array
) -> FeedbackLaw:
    """Return the law of one backward pass along trajectories; low and high bound the commands."""
    A, B = linearise(plant, now.position[:, :-1], now.velocity[:, :-1], now.command)
    quadratic = cost.quadratic(now.position, now.velocity, now.command)
    scale = damping[:, None] / (0.5 * (plant.high - plant.low)) ** 2
    return backward(A, B, quadratic, low - now.command, high - now.command, scale)


def follow(
    plant: Plant,
    plan: Trajectories,
    law: FeedbackLaw,
    low: Array,
    high: Array,
    *,
    length: Array | float = 1.0,
    begin: tuple[Array, Array] | None = None,
) -> Trajectories:
    """Return trajectories under a law; their cost is not computed.

    u = clip(command + length change + gain dx, low, high).

    Args:
        plant: The body.
        plan: Trajectories from which states and commands are counted.
        law: How commands change.
        low: Least commands, shape (rows, periods, m), or (rows, 1, m) for all periods.
        high: Greatest commands.
        length: Share of the change that is made; one number, or one a row.
        begin: Positions (rows, nq) and velocities (rows, nv); None for the plan's own.
    """
    share = np.broadcast_to(np.asarray(length, dtype=float), plan.cost.shape)[:, None]
    q, v, u = plan.position.copy(), plan.velocity.copy(), plan.command.copy()
    if begin is not None:
        q[:, 0], v[:, 0] = begin
    for at in range(u.shape[1]):
        dx = plant.off(q[:, at], v[:, at], plan.position[:, at], plan.velocity[:, at])
        back = (law.gain[:, at] @ dx[..., None])[..., 0]
        wanted = plan.command[:, at] + share * law.change[:, at] + back
        u[:, at] = np.clip(
            wanted, low[:, min(at, low.shape[1] - 1)], high[:, min(at, high.shape[1] - 1)]
        )
        q[:, at + 1], v[:, at + 1] = plant.advance(q[:, at], v[:, at], u[:, at])
    return Trajectories(position=q, velocity=v, command=u, cost=plan.cost)


def restarted(plant: Plant, cost: TaskCost, plan: Trajectories, command: Array) -> Trajectories:
    """Return what a body does from the same starts under other commands, and its cost."""
    if np.array_equal(command, plan.command) and np.isfinite(plan.cost).all():
        return replace(plan, **{name: value.copy() for name, value in vars(plan).items()})
    q, v = plant.rollout(plan.position[:, 0], plan.velocity[:, 0], command)
    return Trajectories(
        position=q, velocity=v, command=command, cost=cost.values(q, v, command).sum(-1)
    )


def _tried(
    plant: Plant, cost: TaskCost, now: Trajectories, law: FeedbackLaw, low: Array, high: Array
) -> Trajectories:
    """Return the best of all lengths, a row each."""
    rows, many = len(now.cost), len(LENGTHS)
    each = np.repeat(np.arange(rows), many)
    length = np.tile(np.array(LENGTHS), rows)
    repeated = FeedbackLaw(
        change=law.change[each], gain=law.gain[each], promised=law.promised[each]
    )
    run = follow(plant, now.rows(each), repeated, low[each], high[each], length=length)
    total = cost.values(run.position, run.velocity, run.command).sum(-1)
    best = np.arange(rows) * many + np.argmin(total.reshape(rows, many), axis=1)
    return replace(run, cost=total).rows(best)
