"""Least squares within bounds, from a Gram matrix."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from morph.arrays import Array

RANK_TOLERANCE = 1e-8
"""Least eigenvalue that counts towards the rank of a Gram matrix with a unit diagonal."""
NEGLIGIBLE = 1e-6
"""Norm of a column, as a share of the greatest, up to which it is taken for zero."""
FELT = 1.0
"""Most change of whitened readings between its bounds by a column that is taken for zero."""


def bounded(inner: Array, along: Array, low: Array, high: Array) -> tuple[Array, int]:
    """Return the least-squares solution within bounds, and the rank of the problem.

    Directions in which the columns are dependent take the solution of least norm, in units of the
    columns. Columns that nowhere between their bounds show stay at zero, or at the nearest bound.
    Source: Stark and Parker 1995, Computational Statistics 10, 129-141 (BVLS).

    Args:
        inner: Gram matrix of the whitened columns, shape (columns, columns).
        along: Inner products of the columns with the goal, shape (columns,).
        low: Least values, each below that of `high`, shape (columns,).
        high: Greatest values, same shape.

    Returns:
        The solution, shape (columns,), and how many independent directions the columns have,
        bounds aside.
    """
    size = np.sqrt(np.maximum(np.diag(inner), 0.0))
    felt = size * np.minimum(high - low, 1e100)
    seen = (size > NEGLIGIBLE * size.max(initial=1e-300)) & (felt > FELT)
    found = np.clip(np.zeros_like(along), low, high)
    if not seen.any():
        return found, 0
    scale = size[seen]
    if len(scale) == 1:
        found[seen] = np.clip(along[seen] / scale**2, low[seen], high[seen])
        return found, 1
    values, vectors = np.linalg.eigh(inner[np.ix_(seen, seen)] / np.outer(scale, scale))
    kept = values > RANK_TOLERANCE
    root = np.sqrt(values[kept])[:, None] * vectors[:, kept].T
    goal = (vectors[:, kept].T @ (along[seen] / scale)) / np.sqrt(values[kept])
    least, most = low[seen] * scale, high[seen] * scale
    best = root.T @ (goal / values[kept])
    if np.any((best < least) | (best > most)):
        best = lsq_linear(root, goal, bounds=(least, most), method="bvls").x
    found[seen] = best / scale
    return found, int(kept.sum())
