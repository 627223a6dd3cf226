"""One embedding for two bodies: neighbours stay near, and so do states that correspond."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError


def together(
    x: Array, y: Array, near_x: Array, near_y: Array, tied: Array, count: int
) -> tuple[Array, Array]:
    """Return alpha (n_s, count) and beta (n_t, count): x alpha and y beta lie together.

    They make sum_ij |alpha' x_i - beta' y_j|^2 w_ij and the same sums over the neighbours within
    each body least, against the weighted variance: Z L Z' g = lambda Z D Z' g, the least first.

    Source: Wang and Mahadevan 2009, IJCAI, theorem 2.

    Args:
        x: Scaled states of the source, shape (m_s, n_s).
        y: Scaled states of the target, shape (m_t, n_t).
        near_x: Weights among the source's, shape (m_s, m_s).
        near_y: Weights among the target's, shape (m_t, m_t).
        tied: Weights between both, shape (m_s, m_t).
        count: How many directions.
    """
    W = np.block([[near_x, tied], [tied.T, near_y]])
    degree = W.sum(axis=1)
    n = x.shape[1]
    Z = np.zeros((len(W), n + y.shape[1]))
    Z[: len(x), :n], Z[len(x) :, n:] = x, y
    spread = (Z * degree[:, None]).T @ Z
    rough = spread - Z.T @ W @ Z
    spread += 1e-6 * np.trace(spread) / len(spread) * np.eye(len(spread))
    directions = eigh(0.5 * (rough + rough.T), 0.5 * (spread + spread.T))[1][:, :count]
    return np.asarray(directions[:n]), np.asarray(directions[n:])


def across(alpha: Array, beta: Array, *, where: str) -> Array:
    """Return the law S with alpha' S = beta', shape (n_s, n_t): from the target to the source.

    Raises:
        MapError: The embedding lost a direction of the source.
    """
    size = np.linalg.svd(alpha, compute_uv=False)
    if len(size) < alpha.shape[0] or size[-1] < 1e-6 * size[0]:
        raise MapError(
            "the joint embedding has lost a direction of the source",
            where=where,
            fix="give more pairs, or bodies that move in as many ways",
        )
    return np.asarray(np.linalg.pinv(alpha.T) @ beta.T)
