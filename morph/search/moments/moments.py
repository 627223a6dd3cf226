"""What a Gaussian process makes of a Gaussian input: exact moments, and their adjoint."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from morph.arrays import Array
from morph.model.gp.gp import GaussianProcess


class Moments(NamedTuple):
    """Mean and covariance of outputs, and how they go with the input."""

    mean: Array
    """E[f], shape (..., e)."""
    covariance: Array
    """Shape (..., e, e)."""
    slope: Array
    """E[df/dx], shape (..., e, d); the covariance of x with f is S slope' (Stein's lemma)."""


class MomentTape(NamedTuple):
    """What the adjoint needs of the way there."""

    delta: Array
    U: Array
    w: Array
    out: Moments
    V: Array
    zeroth: Array
    first: Array
    second: Array


class ProcessMoments:
    """The moments of a Gaussian process at Gaussian inputs, many at once.

    With x ~ N(m, S) and the functions' own uncertainty, mean and covariance of f(x) are sums over
    the data of Gaussian integrals,

        E[f_a] = sum_i b_ai s_a^2 |L_a|^1/2 |L_a + S|^-1/2 exp(-(x_i - m)' U_a (x_i - m) / 2),
        E[f_a f_b] = sum_ij W_ij |L|^1/2 |L + S|^-1/2 exp(-(z_ij - m)' V (z_ij - m) / 2),

    where U_a = inv(L_a + S), V = inv(L + S), inv(L) = inv(L_a) + inv(L_b), and z_ij is the mean of
    x_i and x_j that inv(L_a) and inv(L_b) weight. W holds all that does not depend on the input.
    As such a sum solves the equation of heat, dE/dS = 1/2 d^2E/dm^2, its derivatives are the
    sum's own first and second moments of z_ij - m; so the adjoint is nearly free.

    Source: Deisenroth 2010, Efficient Reinforcement Learning using Gaussian Processes, eqs. 2.34
    to 2.70; Deisenroth and Rasmussen 2011, PILCO, ICML, eqs. 14 to 23. The adjoint is derived
    here.

    Args:
        process: The functions, (e,) of (d,) inputs.
        certain: Whether the functions are taken to be their mean.
    """

    def __init__(self, process: GaussianProcess, *, certain: bool = False) -> None:
        squares = process.lengths**2
        outputs = len(squares)
        apart = [(a, b) for a in range(outputs) for b in range(a + 1, outputs)]
        self.pairs = [*((a, a) for a in range(outputs)), *apart]
        self._scratch = np.empty(0)
        self._first = np.array([a for a, _ in self.pairs])
        self._second = np.array([b for _, b in self.pairs])
        self._twice = np.where(self._first == self._second, 1.0, 2.0)
        La, Lb = squares[self._first], squares[self._second]
        both = 1.0 / (1.0 / La + 1.0 / Lb)
        self._L = np.concatenate([squares, both])
        self._root = np.sqrt(self._L.prod(axis=-1))
        self._to_a, self._to_b = (both / La)[:, None, :], (both / Lb)[:, None, :]
        self._inputs = process.inputs
        self._weights = process.weights * process.signal[:, None] ** 2
        self._own = np.zeros(outputs) if certain else process.signal**2
        self._outputs, self._eye = outputs, np.arange(outputs)
        self._diagonal = np.arange(process.inputs.shape[1])
        self._W = np.stack([self._constant(process, a, b, certain) for a, b in self.pairs])

    def _constant(self, process: GaussianProcess, a: int, b: int, certain: bool) -> Array:
        """Return W of one pair of outputs, shape (n, n)."""
        W = np.outer(process.weights[a], process.weights[b])
        if a == b and not certain:
            W -= process.precision[a]
        x = self._inputs / np.sqrt(process.lengths[a] ** 2 + process.lengths[b] ** 2)
        square = np.square(x).sum(axis=1)
        apart = np.minimum(x @ x.T - 0.5 * square[:, None] - 0.5 * square, 0.0)
        return np.asarray(W * np.exp(apart) * (process.signal[a] * process.signal[b]) ** 2)

    def forward(self, m: Array, S: Array) -> tuple[Moments, MomentTape]:
        """Return the moments at x ~ N(m, S), and what the adjoint needs.

        Args:
            m: Shape (..., d).
            S: Shape (..., d, d).
        """
        e, at = self._outputs, self._diagonal
        T = np.repeat(S[..., None, :, :], len(self._L), axis=-3)
        T[..., at, at] += self._L
        inverse: Array = np.asarray(np.linalg.inv(T), dtype=np.float64)
        scale = self._root * np.sqrt(np.linalg.det(inverse))
        delta = self._inputs - m[..., None, :]
        near = delta[..., None, :, :]
        U, V = inverse[..., :e, :, :], inverse[..., e:, :, :]
        power = ((near @ U) * near).sum(axis=-1)
        power *= -0.5
        w = np.exp(power, out=power)
        w *= self._weights
        w *= scale[..., :e, None]
        mean = w.sum(axis=-1)
        slope = ((w @ delta)[..., None, :] @ U)[..., 0, :]
        zeroth, first, second = self._squares(near, V)
        more = scale[..., e:, None]
        zeroth, first, second = zeroth * more[..., 0], first * more, second * more[..., None]
        covariance = np.empty((*mean.shape, e))
        covariance[..., self._first, self._second] = zeroth
        covariance[..., self._second, self._first] = zeroth
        covariance -= mean[..., :, None] * mean[..., None, :]
        covariance[..., self._eye, self._eye] += self._own
        out = Moments(mean, covariance, slope)
        return out, MomentTape(delta, U, w, out, V, zeroth, first, second)

    def _squares(self, near: Array, V: Array) -> tuple[Array, Array, Array]:
        """Return the sums over pairs of data, and their moments of z - m, without |.| factors."""
        y, z = near * self._to_a, near * self._to_b
        yV, zV = y @ V, z @ V
        d = y.shape[-1]
        left = np.empty((*y.shape[:-1], d + 2))
        right = np.empty((*y.shape[:-1], d + 2))
        np.negative(yV, out=left[..., :d])
        (yV * y).sum(axis=-1, out=left[..., d])
        left[..., d] *= -0.5
        left[..., d + 1] = 1.0
        right[..., :d] = z
        right[..., d] = 1.0
        (zV * z).sum(axis=-1, out=right[..., d + 1])
        right[..., d + 1] *= -0.5
        # The one great array is kept: to be given its memory anew costs as much as filling it.
        shape = (*y.shape[:-1], y.shape[-2])
        if self._scratch.shape != shape:
            self._scratch = np.empty(shape)
        P = np.matmul(left, right.mT, out=self._scratch)
        np.exp(P, out=P)
        P *= self._W
        # In left and right there already is a column of ones, and z stands in right.
        left[..., :d] = y
        rows = P @ right[..., : d + 1]
        # Of a function with itself P is symmetric; those pairs stand first.
        columns, own = rows[..., None, :, d].copy(), self._outputs
        if own < len(self.pairs):
            ones = left[..., own:, None, :, d + 1]
            np.matmul(ones, P[..., own:, :, :], out=columns[..., own:, :, :])
        across = y.mT @ rows
        zeroth = rows[..., d].sum(axis=-1)
        first = across[..., d] + (columns @ z)[..., 0, :]
        mixed = across[..., :d]
        second = (y.mT * rows[..., None, :, d]) @ y + (z.mT * columns) @ z + mixed + mixed.mT
        return zeroth, first, second

    def backward(
        self, tape: MomentTape, mean: Array, covariance: Array, slope: Array
    ) -> tuple[Array, Array]:
        """Return the adjoints of m and S from those of the moments.

        Args:
            tape: What `forward` gave.
            mean: Derivative of some number with respect to E[f], shape (..., e).
            covariance: Likewise, shape (..., e, e).
            slope: Likewise, shape (..., e, d).

        Returns:
            Shapes (..., d) and (..., d, d), the latter symmetric.
        """
        delta, U, w, out, V, zeroth, first, second = tape
        both = 0.5 * (covariance + covariance.mT)
        mean = mean - 2.0 * (both @ out.mean[..., None])[..., 0]
        share = both[..., self._first, self._second] * self._twice
        into_m = ((share[..., None] * first)[..., None, :] @ V)[..., 0, :].sum(axis=-2)
        inner = V @ (second @ V) - zeroth[..., None, None] * V
        into_S = (share[..., None, None] * inner).sum(axis=-3)
        h = (slope[..., None, :] @ U)[..., 0, :]
        wc = w * (h @ delta.mT + mean[..., None])
        r2 = (delta.mT[..., None, :, :] * wc[..., None, :]) @ delta[..., None, :, :]
        into_m = into_m + (
            ((wc @ delta)[..., None, :] @ U)[..., 0, :] - h * out.mean[..., None]
        ).sum(axis=-2)
        into_S = into_S + (U @ (r2 @ U) - wc.sum(axis=-1)[..., None, None] * U).sum(axis=-3)
        turned = h.mT @ out.slope
        return into_m, 0.5 * (into_S - turned - turned.mT)
