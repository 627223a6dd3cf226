"""What is believed of a body's dynamics near rest: before it moved, and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from align.maps.affine_map import AffineMap
from align.samples import Transitions
from morph.arrays import Array
from morph.transfer.body import Body

ROUNDS = 20
"""Rounds in which the evidence chooses how far to trust what was believed beforehand."""

STEP = 1e-4
"""Distance of a finite difference."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Belief:
    """x' = A x + B u."""

    law: Array
    """A, shape (n, n)."""
    command_law: Array
    """B, shape (n, nu)."""


def read(body: Body) -> Belief:
    """Return the linear model of a body whose simulator is ours, by its steps."""
    n, k = body.size, len(body.bounds[0])
    move = np.concatenate([np.eye(n + k), -np.eye(n + k)]) * STEP
    after = body.step(move[:, :n], move[:, n:])
    slope = ((after[: n + k] - after[n + k :]) / (2.0 * STEP)).T
    return Belief(law=slope[:, :n], command_law=slope[:, n:])


def carried(source: Body, seen_as: AffineMap, target: Body, seen: Transitions) -> Array:
    """Return what the source says of the target's accelerations, v' - v, shape (n/2, n + nu).

    J (v' - v) is to be what the source would do at (S y, R a + F y); of all such accelerations
    the least is taken.
    """
    known = read(source)
    half_s, half_t = source.size // 2, target.size // 2
    state = known.law @ seen_as.state_law + known.command_law @ seen_as.read_state
    told = known.command_law @ seen_as.read_law
    rows = np.hstack([state, told])[half_s:]
    rows[:, : target.size] -= seen_as.state_law[half_s:]
    back = np.linalg.pinv(seen_as.state_law[half_s:, half_t:], rcond=1e-6)
    return np.asarray(back @ rows)


def learned(seen: Transitions, prior: Array, target: Body) -> Belief:
    """Return what is believed of a body after its transitions.

    Every row of v' - v = prior (x, u) + W (x, u) is a regression with normal beliefs of W, one
    width for places, one for speeds and one for commands, which the evidence chooses; readings
    are noisy on both sides. Places follow by q' = q + (v + v') period / 2.

    Source: MacKay 1992, Neural Computation 4, eqs. 4.2 to 4.4.
    """
    noise, period = target.task.noise, target.task.period
    n = seen.state.shape[1]
    half, k = n // 2, seen.command.shape[1]
    unit = np.concatenate([np.ones(n), np.sqrt(np.square(seen.command).mean(axis=0)) + 1e-12])
    x = np.hstack([seen.state, seen.command]) / unit
    rise = (seen.after - seen.state)[:, half:]
    groups = (slice(0, half), slice(half, n), slice(n, n + k))
    law = np.zeros((half, n + k))
    for row in range(half):
        before = prior[row] * unit
        left = rise[:, row] - x @ before
        width = np.concatenate([np.full(half, 100.0), np.full(half, 0.1), np.full(k, 0.25)])
        variance = 2.0 * noise**2
        more = np.zeros(n + k)
        for _ in range(ROUNDS):
            cover = np.linalg.inv(np.diag(1.0 / width) + x.T @ x / variance)
            more = cover @ (x.T @ left) / variance
            for group in groups:
                spread = np.square(more[group]) + np.diag(cover)[group]
                width[group] = np.clip(spread.mean(), 1e-6, 1e3)
            slope = (before + more)[:n] + np.eye(n)[half + row]
            variance = noise**2 * (1.0 + np.square(slope).sum())
        law[row] = (before + more) / unit
    return _whole(law, n, period)


def _whole(law: Array, n: int, period: float) -> Belief:
    half = n // 2
    speeds = law[:, :n] + np.hstack([np.zeros((half, half)), np.eye(half)])
    both = np.hstack([np.zeros((half, half)), np.eye(half)]) + speeds
    places = np.hstack([np.eye(half), np.zeros((half, half))]) + 0.5 * period * both
    told = law[:, n:]
    return Belief(
        law=np.vstack([places, speeds]), command_law=np.vstack([0.5 * period * told, told])
    )
