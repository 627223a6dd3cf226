"""Least squares within bounds, from a Gram matrix."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from morph.arrays import Array

SEEN = 1e-8
"""Least eigenvalue of scaled columns that counts as a direction."""


def bounded(inner: Array, along: Array, low: Array, high: Array) -> tuple[Array, int]:
    """Return the least squares within bounds, by their Gram matrix, and its rank."""
    size = np.sqrt(np.maximum(np.diag(inner), 0.0))
    seen = size > 1e-6 * size.max(initial=1e-300)
    found = np.clip(np.zeros_like(along), low, high)
    if not seen.any():
        return found, 0
    scale = size[seen]
    values, vectors = np.linalg.eigh(inner[np.ix_(seen, seen)] / np.outer(scale, scale))
    kept = values > SEEN
    root = np.sqrt(values[kept])[:, None] * vectors[:, kept].T
    goal = (vectors[:, kept].T @ (along[seen] / scale)) / np.sqrt(values[kept])
    least, most = low[seen] * scale, high[seen] * scale
    best = root.T @ (goal / values[kept])
    if np.any((best < least) | (best > most)):
        best = lsq_linear(root, goal, bounds=(least, most), method="bvls").x
    found[seen] = best / scale
    return found, int(kept.sum())
