"""A link's mass, centre and inertia as one matrix, the pseudo-inertia.

J is the integral of [x; 1] [x; 1]^T over the mass, shape (4, 4): second
moments, mass times centre of mass, and mass. A body of positive density has
it positive definite, and every positive definite J is such a body's
(Wensing, Kim and Slotine 2018, RA-L 3(1), theorem 1).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.vary.lock import matrix, quaternion


def pseudo_inertia(body: Any) -> Array:
    """Return the pseudo-inertia of a spec's body in its link's frame, shape (4, 4)."""
    J = np.zeros((4, 4))
    if not body.explicitinertial:
        return J
    axes = matrix(body.iquat)
    # About the centre: the second moment along an axis is half the sum of the
    # inertias about the two others, less that about it.
    second = axes @ np.diag(np.sum(body.inertia) / 2 - body.inertia) @ axes.T
    J[:3, :3] = second + body.mass * np.outer(body.ipos, body.ipos)
    J[:3, 3] = J[3, :3] = body.mass * body.ipos
    J[3, 3] = body.mass
    return J


def set_pseudo_inertia(body: Any, J: Array) -> None:
    """Give a spec's body the mass, centre and inertia of a pseudo-inertia, shape (4, 4)."""
    mass = float(J[3, 3])
    if mass <= 0:
        return
    centre = J[:3, 3] / mass
    moments, axes = np.linalg.eigh(J[:3, :3] - mass * np.outer(centre, centre))
    moments = np.maximum(moments, 0.0)
    if np.linalg.det(axes) < 0:
        axes = -axes
    body.mass, body.ipos, body.iquat = mass, centre, quaternion(axes)
    # Sums of moments that are not negative: the triangle inequality holds.
    body.inertia = (moments[1] + moments[2], moments[0] + moments[2], moments[0] + moments[1])
    body.explicitinertial = True


def between(first: Array, second: Array, fraction: float) -> Array:
    """Return a pseudo-inertia between two, positive definite if both are.

    J = U U^T with U upper triangular; the logarithms of U's diagonal and the
    entries above it, each divided by the last diagonal entry, go in straight
    lines (Rucker and Wensing 2022, RA-L 7(2), eq. 11). So log mass and the
    centre of mass do, too: mass = U44^2, centre = U[:3, 3] / U44. Where an end
    has no thickness and thus no logarithm, J itself goes in a straight line,
    which stays positive semidefinite.

    Args:
        first: J at fraction 0, shape (4, 4).
        second: J at fraction 1, shape (4, 4).
        fraction: 0 to 1.
    """
    if fraction in (0.0, 1.0) or (first == second).all():
        return (second if fraction == 1.0 else first).copy()
    if _flat(first) or _flat(second):
        straight: Array = (1 - fraction) * first + fraction * second
        return straight
    logs = [_logarithms(J) for J in (first, second)]
    return _from_logarithms((1 - fraction) * logs[0] + fraction * logs[1])


def _flat(J: Array) -> bool:
    # Rounding alone leaves a flat body a thickness of 1e-8 of its extent.
    if J[3, 3] <= 0:
        return True
    centre = J[:3, 3] / J[3, 3]
    moments = np.linalg.eigvalsh(J[:3, :3] - J[3, 3] * np.outer(centre, centre))
    return bool(moments[0] <= 1e-12 * moments[-1])


def _logarithms(J: Array) -> Array:
    # Rows and columns reversed, an upper factor becomes Cholesky's lower one.
    U = np.linalg.cholesky(J[::-1, ::-1])[::-1, ::-1]
    last = U[3, 3]
    logs = np.triu(U, 1) / last
    np.fill_diagonal(logs, np.log(np.diagonal(U) / last))
    logs[3, 3] = np.log(last)
    result: Array = logs
    return result


def _from_logarithms(logs: Array) -> Array:
    U = np.triu(logs, 1)
    np.fill_diagonal(U, np.exp(np.diagonal(logs)))
    U[3, 3] = 1.0
    U = U * np.exp(logs[3, 3])
    J: Array = U @ U.T
    return J
