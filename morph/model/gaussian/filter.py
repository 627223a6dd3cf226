"""The Kalman filter with sensitivities to unknowns, for many models at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from morph.arrays import Array


def innovations(
    first: Array, transitions: Iterable[tuple[Array, Array, Array]], noise: Array
) -> Iterator[tuple[Array, Array]]:
    """Yield the innovations of a linear model, whitened, and the logarithm of their density's peak.

    The state is how far a model is from what was observed, then whatever else lasts:

        x(t+1) = F x(t) + u + U theta + w,   w ~ N(0, diag(q)),   -x(t)[:n] ~ N(0, diag(noise^2)).

    With theta, the whitened innovation is that of the first column plus the others times theta, and
    with the true theta innovations are independent and standard normal.

    Source: Särkkä 2013, Bayesian filtering and smoothing, theorem 4.2 and section 12.1;
    sensitivities as in Willsky and Jones 1976, IEEE Trans. Automatic Control 21(1), eqs. 9 to 14.

    Args:
        first: Covariance of the first state, (..., size, size); its mean is zero.
        transitions: F (..., size, size), [u, U] (..., size, 1 + unknowns), q (..., size).
        noise: Standard deviation of each observed number, shape (n,).

    Yields:
        Shapes (..., n, 1 + unknowns) and (...), the latter without theta's part.
    """
    n, spread = len(noise), first
    mean: Array | None = None
    diagonal = np.arange(first.shape[-1])
    for step, moves, added in transitions:
        mean = moves if mean is None else step @ mean + moves
        spread = step @ spread @ np.swapaxes(step, -1, -2)
        spread[..., diagonal, diagonal] += added
        root = np.linalg.cholesky(spread[..., :n, :n] + np.diag(noise**2))
        white = np.linalg.inv(root)
        surprise = white @ -mean[..., :n, :]
        peak = -np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
        gain = white @ spread[..., :n, :]
        mean = mean + np.swapaxes(gain, -1, -2) @ surprise
        spread = spread - np.swapaxes(gain, -1, -2) @ gain
        yield surprise, peak - 0.5 * n * np.log(2.0 * np.pi)
