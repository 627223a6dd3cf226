"""Least squares within bounds, from a Gram matrix."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from morph.arrays import Array

RANK_TOLERANCE = 1e-8
"""Least eigenvalue that counts towards the rank of a Gram matrix with a unit diagonal."""
NEGLIGIBLE = 1e-6
"""Norm of a column, as a share of the greatest, up to which it is taken for zero."""
RIDGE = 1e-9
"""Added to a unit diagonal, so that dependent columns share."""
PATIENCE = 3
"""Exchanges of all entries at once without fewer wrong ones, before they are one at a time."""
SLOPE = 1e-9
"""Slope at a bound, in nats for a change of readings by one standard deviation, taken for none."""
MOST_EXCHANGES = 1000
"""Of which some tens are needed for the hundred columns of a seven-joint arm."""
FELT = 1.0
"""Most change of whitened readings between its bounds by a column that is taken for zero."""


def bounded(inner: Array, along: Array, low: Array, high: Array) -> tuple[Array, int]:
    """Return the least-squares solution within bounds, and the rank of the problem.

    Directions in which the columns are dependent take the solution of least norm, in units of the
    columns. Columns that nowhere between their bounds show stay at zero, or at the nearest bound.

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
    result = np.clip(np.zeros_like(along), low, high)
    if not seen.any():
        return result, 0
    scale = size[seen]
    if len(scale) == 1:
        result[seen] = np.clip(along[seen] / scale**2, low[seen], high[seen])
        return result, 1
    unit = inner[np.ix_(seen, seen)] / np.outer(scale, scale)
    _, _, rank, _ = lapack.dpstrf(unit, tol=RANK_TOLERANCE)
    unit[np.diag_indices_from(unit)] += RIDGE
    result[seen] = (
        _pivoted(unit, along[seen] / scale, low[seen] * scale, high[seen] * scale) / scale
    )
    return result, int(rank)


def _pivoted(inner: Array, along: Array, low: Array, high: Array) -> Array:
    """Return the minimum of x' inner x / 2 - along' x within bounds; inner is positive definite.

    Source: Judice and Pires 1994, Computers and Operations Research 21(5), 587-596 (block principal
    pivoting; single exchanges by the greatest index, which end for sure, where it does not).
    """
    below = above = np.zeros(len(along), dtype=bool)
    fewest, patience = len(along) + 1, PATIENCE
    best = along
    for _ in range(MOST_EXCHANGES):
        free = ~(below | above)
        best = np.where(below, low, np.where(above, high, 0.0))
        if free.any():
            left = (along - inner[:, ~free] @ best[~free])[free]
            block = inner[np.ix_(free, free)]
            _, best[free], failed = lapack.dposv(block, left, lower=1)
            if failed:
                # Rounding of what is left of nearly dependent columns outweighs the ridge.
                best[free] = np.linalg.lstsq(block, left, rcond=RANK_TOLERANCE)[0]
        slope = along - inner @ best
        under, over = free & (best < low), free & (best > high)
        wrong = under | over | (below & (slope > SLOPE)) | (above & (slope < -SLOPE))
        count = int(wrong.sum())
        if not count:
            break
        if count < fewest:
            fewest, patience = count, PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        below, above = np.where(wrong, under, below), np.where(wrong, over, above)
    return np.clip(best, low, high)
