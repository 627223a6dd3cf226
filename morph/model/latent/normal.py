"""Normal equations of states along time and parameters beside them: a band with a border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from morph.arrays import Array
from morph.model.latent.transit import Slopes

LEAST = 1e-13
"""What is added to the diagonal, as a share of it, against rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trust:
    """One over the variances by which errors are weighed."""

    seen: Array
    """Of the observations, shape (n,)."""
    moved: Array
    """Of what the model leaves out in one control period, shape (n,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Band:
    """One run's share of the normal equations, states eliminated.

    With J the sum of squares of one run, z its states and theta the parameters,
    J + dJ is quadratic in (dz, dtheta); eliminating dz leaves a quadratic in dtheta.
    """

    factor: Array
    """Banded Cholesky factor of the states' block."""
    border: Array
    """The block between states and parameters, shape (states, p)."""
    pull: Array
    """Minus the gradient in the states, shape (states,)."""
    hessian: Array
    """Of the parameters, states eliminated, shape (p, p)."""
    slope: Array
    """Minus the gradient in the parameters, states eliminated, shape (p,)."""
    cost: float
    """J / 2 as it is."""
    reach: float
    """By how much J / 2 falls when the states alone take their best values."""

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of the states' block."""
        return 2.0 * float(np.log(self.factor[0]).sum())

    def states(self, change: Array) -> Array:
        """Return the states' best change when parameters change by so much, (states,)."""
        right = self.pull - self.border @ change
        return np.asarray(cho_solve_banded((self.factor, True), right))


def band(slopes: Slopes, state: Array, reading: Array, trust: Trust) -> Band:
    """Return the normal equations of one run about its states.

    Minimised is half the sum over all times of

        |y_t - h(x_t)|^2 in units of the noise + |x_(t+1) - f(x_t)|^2 in units of what is left out.

    Source: Bell 1994, SIAM J. Optimization 4(3), The iterated Kalman smoother as a Gauss-Newton
    method.

    Args:
        slopes: About these states.
        state: x, shape (T + 1, n).
        reading: y, same shape.
        trust: How the two parts are weighed.
    """
    T, n = len(slopes.value), state.shape[1]
    A, B, C = slopes.state, slopes.parameter, slopes.seen_parameter
    p = B.shape[-1]
    missed, off = reading - slopes.seen, state[1:] - slopes.value
    W, Q = trust.seen, trust.moved
    WA = Q[:, None] * A
    diagonal = np.zeros((T + 1, n, n))
    diagonal[:, np.arange(n), np.arange(n)] += W
    diagonal[1:, np.arange(n), np.arange(n)] += Q
    diagonal[:-1] += np.swapaxes(A, 1, 2) @ WA
    # Below the diagonal: d2/dx_(t+1) dx_t = -Q A.
    below = -WA
    weighted = Q[:, None] * B
    border = W[:, None] * C
    border[1:] -= weighted
    border[:-1] += np.swapaxes(A, 1, 2) @ weighted
    pull = W * missed
    pull[1:] -= Q * off
    pull[:-1] += (np.swapaxes(A, 1, 2) @ (Q * off)[..., None])[..., 0]
    factor = cholesky_banded(_banded(diagonal, below), lower=True)
    flat, push = border.reshape((T + 1) * n, p), pull.reshape(-1)
    solved = cho_solve_banded((factor, True), np.column_stack([flat, push]))
    own = np.einsum("tnp,n,tnq->pq", B, Q, B) + np.einsum("tnp,n,tnq->pq", C, W, C)
    drive = np.einsum("tnp,n,tn->p", B, Q, off) + np.einsum("tnp,n,tn->p", C, W, missed)
    return Band(
        factor=factor,
        border=flat,
        pull=push,
        hessian=own - flat.T @ solved[:, :p],
        slope=drive - flat.T @ solved[:, p],
        cost=0.5 * float((W * missed**2).sum() + (Q * off**2).sum()),
        reach=0.5 * float(push @ solved[:, p]),
    )


def _banded(diagonal: Array, below: Array) -> Array:
    """Return blocks on and below the diagonal in LAPACK's lower banded form."""
    times, n = diagonal.shape[:2]
    out = np.zeros((2 * n, times * n))
    at = np.arange(times) * n
    for column in range(n):
        for row in range(column, n):
            out[row - column, at + column] = diagonal[:, row, column]
        for row in range(n):
            out[n + row - column, at[:-1] + column] = below[:, row, column]
    out[0] *= 1.0 + LEAST
    return out
