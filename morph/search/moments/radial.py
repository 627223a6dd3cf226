"""What radial basis functions make of a Gaussian input, with the adjoint of their numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from morph.arrays import Array
from morph.search.moments.moments import Moments


class RadialNumbers(NamedTuple):
    """The numbers of r(x) = sum_k w_k exp(-|(x - c_k) / s|^2 / 2)."""

    centre: Array
    """c, shape (..., k, d)."""
    width: Array
    """Logarithm of s, shape (..., d)."""
    weight: Array
    """w, shape (..., actions, k)."""


class RadialTape(NamedTuple):
    """What the adjoint needs of the way there."""

    numbers: RadialNumbers
    square: Array
    delta: Array
    U: Array
    q: Array
    out: Moments
    V: Array
    Q: Array


def radial_forward(numbers: RadialNumbers, m: Array, S: Array) -> tuple[Moments, RadialTape]:
    """Return the moments of r at x ~ N(m, S), and what the adjoint needs.

    It is the mean of a Gaussian process with one length for all outputs: with z the middle of
    two centres, E[r_a r_b] = sum_ij w_ai w_bj Q_ij,

        Q_ij = |L/2|^1/2 |L/2 + S|^-1/2 exp(-(c_i - c_j)' inv(L) (c_i - c_j) / 4)
               exp(-(z_ij - m)' inv(L/2 + S) (z_ij - m) / 2).

    Source: Deisenroth 2010, section 3.5.2, eqs. 2.34 to 2.70 with a certain function.

    Args:
        numbers: Of the functions.
        m: Shape (..., d).
        S: Shape (..., d, d).
    """
    centre, width, weight = numbers
    square = np.exp(2.0 * width)
    d = m.shape[-1]
    at = np.arange(d)
    T = np.repeat(S[..., None, :, :], 2, axis=-3)
    T[..., 0, at, at] += square
    T[..., 1, at, at] += 0.5 * square
    inverse: Array = np.asarray(np.linalg.inv(T), dtype=np.float64)
    scale = np.sqrt(np.linalg.det(inverse))
    root = np.sqrt(square.prod(axis=-1))
    U, V = inverse[..., 0, :, :], inverse[..., 1, :, :]
    delta = centre - m[..., None, :]
    q = np.exp(-0.5 * ((delta @ U) * delta).sum(axis=-1))
    q *= (root * scale[..., 0])[..., None]
    wq = weight * q[..., None, :]
    mean = wq.sum(axis=-1)
    slope = wq @ delta @ U
    half = np.zeros_like(V)
    half[..., at, at] = 0.5 / square
    quarter = 0.25 * V
    own = -0.5 * ((delta @ (half + quarter)) * delta).sum(axis=-1)
    power = delta @ (half - quarter) @ delta.mT
    power += own[..., None]
    power += own[..., None, :]
    Q = np.exp(power, out=power)
    Q *= (0.5 ** (0.5 * d) * root * scale[..., 1])[..., None, None]
    covariance = weight @ Q @ weight.mT - mean[..., :, None] * mean[..., None, :]
    out = Moments(mean, covariance, slope)
    return out, RadialTape(numbers, square, delta, U, q, out, V, Q)


def radial_backward(
    tape: RadialTape, mean: Array, covariance: Array, slope: Array
) -> tuple[Array, Array, RadialNumbers]:
    """Return the adjoints of m, S and the numbers from those of the moments.

    Args:
        tape: What `radial_forward` gave.
        mean: Derivative of some number with respect to E[r], shape (..., actions).
        covariance: Likewise, shape (..., actions, actions).
        slope: Likewise, shape (..., actions, d).

    Returns:
        Shapes (..., d), (..., d, d) symmetric, and those of the numbers.
    """
    (_, _, weight), square, delta, U, q, out, V, Q = tape
    both = 0.5 * (covariance + covariance.mT)
    mean = mean - 2.0 * (both @ out.mean[..., None])[..., 0]
    at = np.arange(delta.shape[-1])

    spread = both @ weight
    into_weight = 2.0 * spread @ Q
    P = (weight.mT @ spread) * Q
    row = P.sum(axis=-1)
    R = P @ delta
    N, other = -0.25 * V, 0.25 * V
    N[..., at, at] += 0.5 / square
    other[..., at, at] += 0.5 / square
    into_delta = 2.0 * (R @ N - (row[..., None] * delta) @ other)
    own = (delta.mT * row[..., None, :]) @ delta
    across = delta.mT @ R
    total = row.sum(axis=-1)[..., None, None]
    into_S = 0.5 * (V @ (0.5 * (own + across)) @ V - total * V)
    into_width = total[..., 0] + square * into_S[..., at, at]
    into_width = into_width + (own - across)[..., at, at] / square

    h = slope @ U
    c = h @ delta.mT + mean[..., None]
    qc = q[..., None, :] * c
    into_weight = into_weight + qc
    g = (weight * qc).sum(axis=-2)
    into_delta = into_delta - (g[..., None] * delta) @ U
    into_delta = into_delta + (weight * q[..., None, :]).mT @ h
    second = (delta.mT * g[..., None, :]) @ delta
    turned = h.mT @ out.slope
    zeroth = g.sum(axis=-1)[..., None]
    more = 0.5 * (U @ second @ U - zeroth[..., None] * U - turned - turned.mT)
    into_width = into_width + zeroth + 2.0 * square * more[..., at, at]
    return (
        -into_delta.sum(axis=-2),
        into_S + more,
        RadialNumbers(into_delta, into_width, into_weight),
    )
