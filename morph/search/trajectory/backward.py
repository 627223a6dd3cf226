"""The backward pass of differential dynamic programming, for many trajectories at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.search.trajectory.boxed import boxed, freed_gain
from morph.search.trajectory.cost import Quadratic


@dataclass(frozen=True, kw_only=True)
class FeedbackLaw:
    """How commands change with the state: du = change + gain dx."""

    change: Array
    """Shape (rows, periods, m)."""
    gain: Array
    """Shape (rows, periods, m, n)."""
    promised: Array
    """How much the cost should fall, were everything quadratic, shape (rows,)."""


def backward(
    A: Array,
    B: Array,
    cost: Quadratic,
    low: Array,
    high: Array,
    damping: Array,
) -> FeedbackLaw:
    """Return the best change of every command and its gain, from the last period to the first.

    With V the cost-to-go, Q(dx, du) = cost(dx, du) + V(A dx + B du). The change makes Q least
    within the bounds, and the gain is zero for commands that a bound holds.

    Source: Tassa, Mansard and Todorov 2014, Control-Limited Differential Dynamic Programming,
    ICRA, eqs. 5 to 11; the second derivatives of the motion are left out, as in iLQR.

    Args:
        A: Shape (rows, periods, n, n), dx' = A dx + B du.
        B: Shape (rows, periods, n, m).
        cost: Quadratic of each sample, of which there is one more than periods.
        low: Least change of each command, shape (rows, periods, m).
        high: Greatest change.
        damping: Curvature that is added to each command's, shape (rows, m).

    Returns:
        The law, and the quadratic cost-to-go behind it is not kept.
    """
    rows, periods, n, m = B.shape
    change, gain = np.zeros((rows, periods, m)), np.zeros((rows, periods, m, n))
    promised = np.zeros(rows)
    Vx, Vxx = cost.x[:, -1], cost.xx[:, -1]
    added = damping[..., None] * np.eye(m)
    for at in reversed(range(periods)):
        a, b = A[:, at], B[:, at]
        at_, bt = np.swapaxes(a, -1, -2), np.swapaxes(b, -1, -2)
        towards = bt @ Vxx
        Qx = cost.x[:, at] + (at_ @ Vx[..., None])[..., 0]
        Qu = cost.u[:, at] + (bt @ Vx[..., None])[..., 0]
        Qxx = cost.xx[:, at] + at_ @ Vxx @ a
        Qux = cost.ux[:, at] + towards @ a
        Quu = cost.uu[:, at] + towards @ b
        k, free = boxed(Quu + added, Qu, low[:, at], high[:, at])
        K = freed_gain(Quu + added, Qux, free)
        Kt = np.swapaxes(K, -1, -2)
        pressed = (Quu @ k[..., None])[..., 0]
        promised -= np.sum(k * (Qu + 0.5 * pressed), axis=-1)
        Vx = (
            Qx
            + (Kt @ (Qu + pressed)[..., None])[..., 0]
            + (np.swapaxes(Qux, -1, -2) @ k[..., None])[..., 0]
        )
        Vxx = Qxx + Kt @ Quu @ K + Kt @ Qux + np.swapaxes(Qux, -1, -2) @ K
        Vxx = 0.5 * (Vxx + np.swapaxes(Vxx, -1, -2))
        change[:, at], gain[:, at] = k, K
    return FeedbackLaw(change=change, gain=gain, promised=promised)
