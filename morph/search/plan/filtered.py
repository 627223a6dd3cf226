"""Feedback from all that was seen of late: the state is estimated as a Kalman filter does it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.search.plan.initial_trajectories import SeedInputs
from morph.search.plan.terminal_controller import aided
from morph.search.trajectory.backward import backward
from morph.search.trajectory.cost import Quadratic
from morph.search.trajectory.ddp import Trajectories
from morph.search.trajectory.linearise import linearise

AGES = 30
"""Samples that a filter looks back; what was seen before is forgotten."""

SURELY = 1e-4
"""Standard deviation of what is known surely: a start, in shares of a sample's noise beside it."""

PRESSED = 0.02
"""Share of a command's range from its bound within which half of the feedback is clipped."""

SETTLED = 24
"""Periods at rest after which a filter there is taken to have settled."""


@dataclass(frozen=True, kw_only=True)
class Along:
    """What a body does near a plan: dz' = A dz + B du, of which dz[:n] is seen."""

    A: Array
    """Shape (plans, periods, size, size)."""
    B: Array
    """Shape (plans, periods, size, m)."""
    cost: Quadratic
    """What feedback makes least, of periods + 1 samples."""
    push: Array
    """What a force in place of each command would do, shape (plans, periods, size, m)."""
    passed: Array
    """Share of a change of a command that its bounds let through, (plans, periods, m)."""


def along(ground: SeedInputs, plans: Trajectories, still: int = SETTLED) -> Along:
    """Return what a body does near plans, and then for some periods at rest."""
    plant, rest = ground.plant, ground.still
    A, B = linearise(plant, plans.position[:, :-1], plans.velocity[:, :-1], plans.command)
    A0, B0 = linearise(plant, rest.position, rest.velocity, rest.command)
    rows = len(plans.cost)
    A = np.concatenate([A, np.broadcast_to(A0, (rows, still, *A0.shape))], axis=1)
    B = np.concatenate([B, np.broadcast_to(B0, (rows, still, *B0.shape))], axis=1)
    half = 0.5 * (plant.high - plant.low)
    here = aided(ground.cost, plans.position, plans.velocity, plans.command)
    end = aided(
        ground.cost,
        rest.position[None, None],
        rest.velocity[None, None],
        rest.command[None, None],
    )
    xx = np.concatenate(
        [here.xx, np.broadcast_to(end.xx, (rows, still, *end.xx.shape[2:]))], axis=1
    )
    uu = np.concatenate(
        [here.uu, np.broadcast_to(end.uu, (rows, still, *end.uu.shape[2:]))], axis=1
    )
    uu = ground.regulator.effort * (np.diag(half**-2.0) + uu)
    n, m, samples = xx.shape[-1], uu.shape[-1], xx.shape[1]
    xx[:, -1] += ground.regulator.worth
    near = np.minimum(plans.command - plant.low, plant.high - plans.command)
    passed = np.where(near < PRESSED * 2.0 * half, 0.5, 1.0)
    return Along(
        A=A,
        B=B,
        cost=Quadratic(
            x=np.zeros((rows, samples, n)),
            u=np.zeros((rows, samples, m)),
            xx=xx,
            uu=uu,
            ux=np.zeros((rows, samples, m, n)),
        ),
        push=B,
        passed=np.concatenate([passed, np.ones((rows, still, m))], axis=1),
    )


def filtered(
    ground: SeedInputs, near: Along, effort: float, doubt: float, *, ages: int = AGES
) -> Array:
    """Return the gain on what was seen at each sample and before, (plans, periods + 1, m, ages, n).

    The feedback of the linear-quadratic problem acts on an estimate of the state. Estimates are
    sums over all that was seen, dz = sum_i Z_i dy_i, and so are commands:

        Z' = (A + B K) Z,  then  Z <- (1 - L C) Z, and L for the sample that is new.

    The gain of the last sample is that at rest.

    Source: Anderson and Moore 1979, Optimal Filtering, section 5.4, the filter in its covariance
    form; 1990, Optimal Control: Linear Quadratic Methods, chapter 8.

    Args:
        ground: The task and the body.
        near: What the body does near the plans.
        effort: What the commands of the feedback cost, in costs of the regulator's.
        doubt: How much the model errs: standard deviation of a force in place of the commands, as
            a share of half their range, new in every period; infinite for no filter.
        ages: Samples that are looked back.
    """
    K = gains(near, effort)
    rows, periods, size, m = near.B.shape
    n = 2 * ground.plant.model.nv
    if not np.isfinite(doubt):
        result = np.zeros((rows, periods, m, ages, n))
        result[..., 0, :] = K[..., :n]
        return _ended(result, ground.periods)
    noise = max(ground.cost.task.noise, 1e-9)
    half = 0.5 * (ground.plant.high - ground.plant.low)
    C = np.eye(n, size)
    spread = ground.cost.task.start.spread
    P = np.zeros((rows, size, size))
    P[:, :n, :n] = np.eye(n) * (spread**2 + (SURELY * noise) ** 2)
    Z = np.zeros((rows, size, ages, n))
    result = np.empty((rows, periods, m, ages, n))
    for at in range(periods):
        L = np.swapaxes(np.linalg.solve(P[:, :n, :n] + noise**2 * np.eye(n), P[:, :n]), -1, -2)
        kept = np.eye(size) - L @ C
        P = kept @ P
        Z = np.einsum("rij,rjan->rian", kept, Z)
        Z[:, :, 0] += L
        result[:, at] = np.einsum("rmi,rian->rman", K[:, at], Z)
        a, b = near.A[:, at], near.B[:, at]
        closed = a + b @ (near.passed[:, at, :, None] * K[:, at])
        pushed = near.push[:, at] * (doubt * half)
        P = a @ P @ np.swapaxes(a, -1, -2) + pushed @ np.swapaxes(pushed, -1, -2)
        Z = np.einsum("rij,rjan->rian", closed, Z)
        Z[:, :, 1:] = Z[:, :, :-1].copy()
        Z[:, :, 0] = 0.0
    return _ended(result, ground.periods)


def gains(near: Along, effort: float) -> Array:
    """Return the gain on the whole state at each period, shape (plans, periods, m, size)."""
    rows, _, _, m = near.B.shape
    pressed = Quadratic(**{**vars(near.cost), "uu": effort * near.cost.uu})
    wide = np.full((*near.B.shape[:2], m), np.inf)
    return backward(near.A, near.B, pressed, -wide, wide, np.zeros((rows, m))).gain


def _ended(result: Array, periods: int) -> Array:
    """Return gains of the plan's periods and of rest, where the last but some are settled.

    Towards its end the problem asks for less, so what is at rest is taken from its middle.
    """
    return np.concatenate(
        [result[:, :periods], result[:, (periods + result.shape[1]) // 2, None]], 1
    )
