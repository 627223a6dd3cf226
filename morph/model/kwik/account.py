"""A run as independent pieces of evidence on what a model leaves out, by a filter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Account:
    """What each transition of a run says of the unknowns, independent of all before.

    The surprise of transition t, in its own standard deviations, is z_t - Z_t theta; with the
    true theta these are independent and standard normal, so

        log p(run | theta) = - 1/2 sum_t |z_t - Z_t theta|^2 + constant.
    """

    surprise: Array
    """z, shape (periods, n)."""
    slope: Array
    """Z, shape (periods, n, unknowns)."""


def account(
    reading: Array, ahead: Array, state: Array, unknown: Array, *, noise: Array, unsaid: Array
) -> Account:
    """Return what a run says of unknowns that enter its transitions linearly.

    With x the state and y what is observed of it,

        x_(t+1) = f(y_t) + A_t (x_t - y_t) + B_t theta + w_t,   y_t = x_t + v_t.

    A Kalman filter with theta = 0 carries along how its estimate depends on theta. A noisy y_t
    is wrong in the transition to it and in that from it: the filter, unlike a regression of
    y_(t+1) on y_t, counts this once.

    Source: Kalman 1960, J. Basic Engineering 82(1); sensitivities as in Willsky and Jones 1976,
    IEEE Trans. Automatic Control 21(1), eqs. 9 to 14.

    Args:
        reading: y, shape (periods + 1, n).
        ahead: f(y_t), shape (periods, n).
        state: A, shape (periods, n, n).
        unknown: B, shape (periods, n, unknowns).
        noise: Standard deviation of v, shape (n,).
        unsaid: Standard deviation of w, shape (n,).
    """
    n, size = reading.shape[1], unknown.shape[2]
    R, Q = np.diag(noise**2), np.diag(unsaid**2)
    off, S, P = np.zeros(n), np.zeros((n, size)), R
    z, Z = np.empty((len(ahead), n)), np.empty((len(ahead), n, size))
    for t, A in enumerate(state):
        S = A @ S + unknown[t]
        P = A @ P @ A.T + Q
        missed = reading[t + 1] - ahead[t] - A @ off
        F = P + R
        lower = np.linalg.cholesky(F)
        z[t] = np.linalg.solve(lower, missed)
        Z[t] = np.linalg.solve(lower, S)
        gain = np.linalg.solve(F, P).T
        # `off` is the estimate less the reading: the next transition begins at the reading.
        off = gain @ missed - missed
        S = S - gain @ S
        P = P - gain @ P
        P = 0.5 * (P + P.T)
    return Account(surprise=z, slope=Z)
