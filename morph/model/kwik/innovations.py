"""Independent innovations of a run under a model with a missing force (Kalman filter)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.filter import innovations


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

    A noisy y_t is wrong in the transition to it and in that from it: the filter, unlike a
    regression of y_(t+1) on y_t, counts this once.

    Args:
        reading: y, shape (periods + 1, n).
        ahead: f(y_t), shape (periods, n).
        state: A, shape (periods, n, n).
        unknown: B, shape (periods, n, unknowns).
        noise: Standard deviation of v, shape (n,).
        unsaid: Standard deviation of w, shape (n,).
    """
    moves = np.concatenate([(ahead - reading[1:])[..., None], unknown], axis=2)
    transitions = zip(state, moves, np.broadcast_to(unsaid**2, ahead.shape), strict=True)
    result = np.stack([each for each, _ in innovations(np.diag(noise**2), transitions, noise)])
    return Account(surprise=result[..., 0], slope=-result[..., 1:])
