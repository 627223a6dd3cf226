"""Graphs of neighbours, and how alike the neighbourhoods of two bodies are."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.regression import apart


def neighbours(z: Array, nearest: int) -> Array:
    """Return the weights of a graph of nearest neighbours, symmetric, shape (m, m).

    w_ij = exp(-|z_i - z_j|^2 / (2 t)) if either is among the other's nearest, t the mean of those
    squared distances.

    Source: Belkin and Niyogi 2003, Neural Computation 15(6), section 2.

    Args:
        z: Scaled data, shape (m, n).
        nearest: How many neighbours each has.
    """
    square = apart(z, z)
    np.fill_diagonal(square, np.inf)
    count = min(nearest, len(z) - 1)
    near = np.argpartition(square, count - 1, axis=1)[:, :count]
    joined = np.zeros(square.shape, dtype=bool)
    np.put_along_axis(joined, near, True, axis=1)
    joined |= joined.T
    width = max(float(square[joined].mean()), 1e-12)
    return np.asarray(np.where(joined, np.exp(-0.5 * square / width), 0.0))


def patterns(z: Array, nearest: int) -> Array:
    """Return the distances among each point and its nearest, shape (m, nearest + 1, nearest + 1).

    Source: Wang and Mahadevan 2009, IJCAI, section 3.1.
    """
    square = apart(z, z)
    order = np.argsort(square, axis=1, kind="stable")[:, : nearest + 1]
    # The point itself is the first, whatever else lies at the same place.
    order[:, 0] = np.arange(len(z))
    group = z[order]
    gap = group[:, :, None] - group[:, None]
    return np.asarray(np.sqrt(np.square(gap).sum(axis=-1)))


def alike(ours: Array, theirs: Array) -> Array:
    """Return how alike local patterns are, whatever their size, shape (m_s, m_t), 0 to 1.

    With R and R' two patterns, d is the least over all orders h of the neighbours and over which
    of both is scaled by the best factor k: d = min(|R'_h - k R|, |R - k' R'_h|), and they are
    alike by exp(-d / delta) with delta the median of all d.

    Source: Wang and Mahadevan 2009, IJCAI, theorem 1 (the factor k in closed form).

    Args:
        ours: Shape (m_s, k + 1, k + 1).
        theirs: Shape (m_t, k + 1, k + 1).
    """
    k = ours.shape[1] - 1
    flat = ours.reshape(len(ours), -1)
    best = np.full((len(ours), len(theirs)), -np.inf)
    for order in permutations(range(1, k + 1)):
        turn = [0, *order]
        turned = theirs[:, turn][:, :, turn].reshape(len(theirs), -1)
        # |R'_h - k R|^2 is least where tr(R' R'_h) is greatest, and so for the other way.
        best = np.maximum(best, flat @ turned.T)
    a = np.square(flat).sum(axis=1)[:, None]
    b = np.square(theirs.reshape(len(theirs), -1)).sum(axis=1)
    share = np.square(best) / np.maximum(a * b, 1e-300)
    off = np.sqrt(np.maximum(np.minimum(a, b) * (1.0 - share), 0.0))
    return np.asarray(np.exp(-off / max(float(np.median(off)), 1e-12)))
