"""Feedback that balances, from what is believed of a body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import solve_discrete_are

from morph.arrays import Array
from morph.policy_transfer.body import Body
from morph.policy_transfer.mapped.belief import LinearPosterior, read

POSTURE = 0.1
"""What a radian or metre of every joint costs beside the outcome."""

RATE = 0.04
"""What a unit of speed costs against a unit of place."""

EFFORT = 0.1
"""What half of the range of a command costs."""

KEPT = 0.999
"""What a period's cost counts against the period before it."""

DOUBTS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01, 1e-3, 0.0)
"""Shares of the covariance that feedback heeds; the greatest that some feedback bears is taken."""

SWEEPS = 400
"""Most steps of value iteration."""

NEARLY = 0.8
"""Share of the best foreseen score at which the feedback that comes first is taken."""

DRAWS = 12
"""Bodies drawn from a belief by which to judge feedback."""


def costs(target: Body) -> tuple[Array, Array]:
    """Return what states and commands cost: Q = C'C + posture, R of half ranges."""
    half = target.size // 2
    posture = np.diag([1.0] * half + [RATE] * half)
    low, high = target.bounds
    span = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    outcome = target.outcome
    return outcome.T @ outcome + POSTURE * posture, EFFORT * target.dear * np.diag(1.0 / span**2)


def plain(step: Array, target: Body) -> Array:
    """Return the feedback that is best if (A, B) are right, shape (nu, n)."""
    Q, R = costs(target)
    n = len(step)
    A, B = step[:, :n], step[:, n:]
    scale = np.sqrt(KEPT)
    for dearer in (1.0, 1e2, 1e4):
        try:
            P = solve_discrete_are(scale * A, scale * B, Q, dearer * R)
        except (np.linalg.LinAlgError, ValueError):
            continue
        return np.asarray(-np.linalg.solve(dearer * R + KEPT * B.T @ P @ B, KEPT * B.T @ P @ A))
    return np.zeros((B.shape[1], n))


def cautious(believed: LinearPosterior, target: Body) -> Array:
    """Return the feedback of least expected cost where (A, B) are uncertain, shape (nu, n).

    As if each period drew them anew: P = Q + E[A'PA] - E[A'PB] inv(R + E[B'PB]) E[B'PA]. Where
    no feedback has a finite cost, less of the covariance is heeded.

    Source: De Koning 1982, Automatica 18(4), eqs. 8 to 11.
    """
    Q, R = costs(target)
    step, doubt = believed.step, believed.doubt
    n, width = step.shape
    paid = np.zeros((width, width))
    paid[:n, :n], paid[n:, n:] = Q, R
    for share in DOUBTS:
        result = _iterated(step, share * doubt, paid)
        if result is not None:
            return result
    return plain(step, target)


def _iterated(step: Array, doubt: Array, paid: Array) -> Array | None:
    n = len(step)
    P = paid[:n, :n].copy()
    most = 1e6 * np.abs(P).max()
    for _ in range(SWEEPS):
        unsure = np.tensordot(P, doubt, axes=([0, 1], [0, 2]))
        both = paid + KEPT * (step.T @ P @ step + unsure)
        gain = -np.linalg.solve(both[n:, n:], both[n:, :n])
        new = both[:n, :n] + both[:n, n:] @ gain
        new = 0.5 * (new + new.T)
        change = np.abs(new - P).max() / np.abs(P).max()
        P = new
        if not np.abs(P).max() < most:
            return None
        if change < 1e-3:
            return np.asarray(gain)
    return None


def foreseen(gain: Array, steps: Array, target: Body, rng: np.random.Generator) -> float:
    """Return the score that feedback would have on bodies (A, B) drawn from a belief, 0 to 1.

    Runs begin as the task's do, readings are noisy, commands are bounded, and bodies linear.
    """
    count = len(steps)
    task = target.task
    q, v = task.start.sample(task.robot, target.plant.model, count, rng)
    x = target.seen(target.state(q, v))
    low, high = target.bounds
    outcome = target.outcome[: len(target.outcome) // 2]
    alive, total = np.ones(count, dtype=bool), np.zeros(count)
    for _ in range(task.samples - 1):
        u = np.clip((x + task.noise * rng.standard_normal(x.shape)) @ gain.T, low, high)
        x = np.einsum("rij,rj->ri", steps, np.concatenate([x, u], axis=1))
        square = np.square(x @ outcome.T).sum(axis=1)
        alive &= square < 9.0
        x = np.where(alive[:, None], x, 0.0)
        total += np.where(alive, np.exp(-0.5 * square), 0.0)
    return float(total.mean() / (task.samples - 1))


def chosen(
    choices: Mapping[str, Array], believed: LinearPosterior, target: Body, rng: np.random.Generator
) -> tuple[str, Array]:
    """Return feedback, with its name: the first that is foreseen to score nearly the best.

    What is foreseen of feedback is judged by the very belief that it is made from, and few draws
    tell little: what stands first is left only for what is clearly better.
    """
    steps = believed.drawn(DRAWS, rng)
    seed = int(rng.integers(2**31))
    scores = {
        name: foreseen(gain, steps, target, np.random.default_rng(seed))
        for name, gain in choices.items()
    }
    best = max(scores.values())
    name = next(name for name in choices if scores[name] >= NEARLY * best)
    return name, choices[name]


def holding(body: Body) -> Array:
    """Return the feedback of a body whose simulator is ours, shape (nu, n)."""
    return plain(read(body), body)
