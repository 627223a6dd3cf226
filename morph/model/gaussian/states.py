"""Normal equations of states along time and unknowns beside them: a band with a border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from morph.arrays import Array
from morph.model.gaussian.information import Information

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
class ReducedEquations:
    """One run's share of the normal equations, states eliminated.

    With J the sum of squares of one run, z its states and theta the unknowns, J + dJ is quadratic
    in (dz, dtheta); eliminating dz leaves a quadratic in dtheta.
    """

    factor: Array
    """Banded Cholesky factor of the states' block."""
    border: Array
    """The block between states and unknowns, shape (states, p)."""
    pull: Array
    """Minus the gradient in the states, shape (states,)."""
    hessian: Array
    """Of the unknowns, states eliminated, shape (p, p)."""
    slope: Array
    """Minus the gradient in the unknowns, states eliminated, shape (p,)."""
    cost: float
    """J / 2 as it is."""
    reach: float
    """By how much J / 2 falls when the states alone take their best values."""

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of the states' block."""
        return 2.0 * float(np.log(self.factor[0]).sum())

    @property
    def information(self) -> Information:
        """What the run says of the change of unknowns, up to a constant of the trust."""
        c = 2.0 * (self.cost - self.reach) + self.log_determinant
        return Information(H=self.hessian, b=self.slope, c=c)

    def states(self, change: Array) -> Array:
        """Return the states' best change when unknowns change by so much, (states,)."""
        right = self.pull - self.border @ change
        return np.asarray(cho_solve_banded((self.factor, True), right))


def band(
    *,
    state: Array,
    unknown: Array,
    seen_unknown: Array | None = None,
    off: Array,
    missed: Array,
    trust: Trust,
) -> ReducedEquations:
    """Return the normal equations of one run about its states.

    Minimised is half the sum over all times of

        |y_t - h(x_t)|^2 in units of the noise + |x_(t+1) - f(x_t)|^2 in units of what is left out.

    Source: Bell 1994, SIAM J. Optimization 4(3), The iterated Kalman smoother as a Gauss-Newton
    method.

    Args:
        state: df/dx about these states, shape (T, n, n).
        unknown: df/dtheta, shape (T, n, p).
        seen_unknown: dh/dtheta, shape (T + 1, n, p); None for zero. dh/dx is one.
        off: x_(t+1) - f(x_t), shape (T, n).
        missed: y_t - h(x_t), shape (T + 1, n).
        trust: How the two parts are weighed.
    """
    (T, n, p), A = unknown.shape, state
    W, Q = trust.seen, trust.moved
    forward = np.swapaxes(A, 1, 2)
    diagonal = np.zeros((T + 1, n, n))
    diagonal[:, np.arange(n), np.arange(n)] += W
    diagonal[1:, np.arange(n), np.arange(n)] += Q
    diagonal[:-1] += forward @ (Q[:, None] * A)
    # Below the diagonal: d2/dx_(t+1) dx_t = -Q A.
    below = -Q[:, None] * A
    weighted = Q[:, None] * unknown
    border = np.zeros((T + 1, n, p))
    border[1:] -= weighted
    border[:-1] += forward @ weighted
    pull = W * missed
    pull[1:] -= Q * off
    pull[:-1] += (forward @ (Q * off)[..., None])[..., 0]
    inner = unknown.reshape(T * n, p).T @ weighted.reshape(T * n, p)
    drive = weighted.reshape(T * n, p).T @ off.ravel()
    if seen_unknown is not None:
        seen = W[:, None] * seen_unknown
        border += seen
        inner += seen_unknown.reshape(T * n + n, p).T @ seen.reshape(T * n + n, p)
        drive += seen.reshape(T * n + n, p).T @ missed.ravel()
    factor = cholesky_banded(_banded(diagonal, below), lower=True)
    flat, push = border.reshape(T * n + n, p), pull.ravel()
    solved = cho_solve_banded((factor, True), np.column_stack([flat, push]))
    return ReducedEquations(
        factor=factor,
        border=flat,
        pull=push,
        hessian=inner - flat.T @ solved[:, :p],
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
