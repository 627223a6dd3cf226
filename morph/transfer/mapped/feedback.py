"""Feedback that balances, from a linear model of a body."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_discrete_are

from morph.arrays import Array
from morph.transfer.body import Body
from morph.transfer.mapped.belief import Belief, read

POSTURE = 0.1
"""What a radian or metre of every joint costs beside the outcome."""

RATE = 0.04
"""What a unit of speed costs against a unit of place."""

EFFORT = 0.1
"""What half of the range of a command costs."""

KEPT = 0.999
"""What a period's cost counts against the period before it."""


def costs(target: Body) -> tuple[Array, Array]:
    """Return what states and commands cost: Q = C'C + posture, R of half ranges."""
    half = target.size // 2
    posture = np.diag([1.0] * half + [RATE] * half)
    low, high = target.bounds
    span = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    outcome = target.outcome
    return outcome.T @ outcome + POSTURE * posture, EFFORT * np.diag(1.0 / span**2)


def feedback(target: Body, believed: Belief) -> Array:
    """Return the feedback that is best by what is believed of a body, shape (nu, n)."""
    A, B = believed.law, believed.command_law
    Q, R = costs(target)
    scale = np.sqrt(KEPT)
    for dearer in (1.0, 1e2, 1e4):
        try:
            P = solve_discrete_are(scale * A, scale * B, Q, dearer * R)
        except (np.linalg.LinAlgError, ValueError):
            continue
        return np.asarray(-np.linalg.solve(dearer * R + KEPT * B.T @ P @ B, KEPT * B.T @ P @ A))
    return np.zeros((B.shape[1], A.shape[0]))


def holding(body: Body) -> Array:
    """Return the feedback of a body whose simulator is ours, shape (nu, n)."""
    return feedback(body, read(body))
