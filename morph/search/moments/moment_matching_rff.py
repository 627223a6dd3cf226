"""Moments of sines and cosines of Gaussian angles, with adjoints; used for squashing too."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np

from morph.arrays import Array


class AngleWaves(NamedTuple):
    """The characteristic function of angles, and of their sums and differences."""

    single: Array
    """E[exp(i a_j)], shape (..., k), complex."""
    sum: Array
    """E[exp(i (a_j + a_k))], shape (..., k, k), complex."""
    difference: Array
    """E[exp(i (a_j - a_k))], likewise."""


def waves_forward(mean: Array, covariance: Array) -> AngleWaves:
    """Return the characteristic function of Gaussian angles, of which all moments are made.

    E[exp(i w' a)] = exp(i w' m - w' S w / 2). With it E[sin a] is the imaginary part of `single`,
    and E[sin a_j sin a_k] half the real part of `difference - sum`.

    Source: Deisenroth 2010, appendix A.1, in complex form.

    Args:
        mean: m, rad, shape (..., k).
        covariance: S, shape (..., k, k).
    """
    variance = -0.5 * np.diagonal(covariance, axis1=-2, axis2=-1)
    level = variance[..., :, None] + variance[..., None, :]
    turn = np.exp(1j * mean)
    both = turn[..., :, None] * turn[..., None, :]
    apart = turn[..., :, None] * turn.conj()[..., None, :]
    return AngleWaves(
        np.exp(variance) * turn,
        np.exp(level - covariance) * both,
        np.exp(level + covariance) * apart,
    )


def waves_backward(tape: AngleWaves, wanted: AngleWaves) -> tuple[Array, Array]:
    """Return the adjoints of mean and covariance, shapes (..., k) and (..., k, k).

    Args:
        tape: What `waves_forward` gave.
        wanted: Derivative of some number with respect to it: the real part with respect to its
            real part, the imaginary part with respect to its imaginary part.
    """
    single = wanted.single.conj() * tape.single
    total = wanted.sum.conj() * tape.sum
    apart = wanted.difference.conj() * tape.difference
    level = total.real + apart.real
    into_S = apart.real - total.real
    into_mean = -single.imag - total.imag.sum(axis=-1) - total.imag.sum(axis=-2)
    into_mean = into_mean - apart.imag.sum(axis=-1) + apart.imag.sum(axis=-2)
    variance = single.real + level.sum(axis=-1) + level.sum(axis=-2)
    at = np.arange(variance.shape[-1])
    into_S[..., at, at] -= 0.5 * variance
    return into_mean, into_S


class LiftTape(NamedTuple):
    """What the adjoint of a lift needs."""

    S: Array
    waves: AngleWaves
    cross: Array


class Lift:
    """States to which the sines and cosines of some angles are appended.

    Args:
        angles: Which sums of the state's numbers are the angles, shape (k, d), rad.
    """

    def __init__(self, angles: Array) -> None:
        self.angles = angles
        k, d = angles.shape
        self._x, self._s, self._c = slice(0, d), slice(d, d + k), slice(d + k, d + 2 * k)
        self.size = d + 2 * k

    def forward(self, m: Array, S: Array) -> tuple[Array, Array, LiftTape]:
        """Return mean and covariance of (x, sin a, cos a), and what the adjoint needs.

        Args:
            m: Shape (..., d).
            S: Shape (..., d, d).
        """
        cross = S @ self.angles.T
        waves = waves_forward(m @ self.angles.T, self.angles @ cross)
        sine, cosine = waves.single.imag, waves.single.real
        mean = np.concatenate([m, sine, cosine], axis=-1)
        C = np.empty((*m.shape[:-1], self.size, self.size))
        x, s, c = self._x, self._s, self._c
        C[..., x, x] = S
        C[..., x, s] = cross * cosine[..., None, :]
        C[..., x, c] = cross * -sine[..., None, :]
        C[..., s, x], C[..., c, x] = C[..., x, s].mT, C[..., x, c].mT
        half, less = 0.5 * waves.sum, 0.5 * waves.difference
        C[..., s, s] = less.real - half.real - sine[..., :, None] * sine[..., None, :]
        C[..., c, c] = less.real + half.real - cosine[..., :, None] * cosine[..., None, :]
        C[..., s, c] = less.imag + half.imag - sine[..., :, None] * cosine[..., None, :]
        C[..., c, s] = C[..., s, c].mT
        return mean, C, LiftTape(S, waves, cross)

    def backward(self, tape: LiftTape, mean: Array, covariance: Array) -> tuple[Array, Array]:
        """Return the adjoints of m and S, shapes (..., d) and (..., d, d), symmetric.

        Args:
            tape: What `forward` gave.
            mean: Derivative of some number with respect to the mean, shape (..., size).
            covariance: Likewise, symmetric, shape (..., size, size).
        """
        _, waves, cross = tape
        x, s, c = self._x, self._s, self._c
        sine, cosine = waves.single.imag, waves.single.real
        ss, cc, sc = covariance[..., s, s], covariance[..., c, c], covariance[..., s, c]
        xs, xc = 2.0 * covariance[..., x, s], 2.0 * covariance[..., x, c]
        into_sine = mean[..., s] - 2.0 * _times(ss, sine) - 2.0 * _times(sc, cosine)
        into_sine = into_sine - (xc * cross).sum(axis=-2)
        into_cosine = mean[..., c] - 2.0 * _times(cc, cosine) - 2.0 * _times(sc.mT, sine)
        into_cosine = into_cosine + (xs * cross).sum(axis=-2)
        wanted = AngleWaves(
            into_cosine + 1j * into_sine,
            0.5 * (cc - ss) + 1j * sc,
            0.5 * (cc + ss) + 1j * sc,
        )
        into_angle, into_spread = waves_backward(waves, wanted)
        into_cross = xs * cosine[..., None, :] - xc * sine[..., None, :]
        into_cross = into_cross + self.angles.T @ into_spread
        into_S = covariance[..., x, x] + into_cross @ self.angles
        into_m = mean[..., x] + into_angle @ self.angles
        return into_m, 0.5 * (into_S + into_S.mT)


class Squasher(ABC):
    """What makes commands of a law's numbers r."""

    @abstractmethod
    def forward(self, m: Array, S: Array) -> tuple[Array, Array, Array, Any]:
        """Return mean and covariance of u, E[du/dr], shape (..., actions), and the tape."""

    @abstractmethod
    def backward(
        self, tape: Any, mean: Array, covariance: Array, gain: Array
    ) -> tuple[Array, Array]:
        """Return the adjoints of m and S from those of what `forward` gave."""


class Squash(Squasher):
    """Commands low <= u <= high out of numbers r of any size: (9 sin r + sin 3r) / 8, scaled.

    Source: Deisenroth, Fox and Rasmussen 2015, IEEE TPAMI 37(2), section 4.1.

    Args:
        low: Shape (actions,).
        high: Shape (actions,).
    """

    def __init__(self, low: Array, high: Array) -> None:
        eye, half = np.eye(len(low)), np.diag(0.5 * (high - low))
        self._middle = 0.5 * (low + high)
        self._angles = np.concatenate([eye, 3.0 * eye])
        self._share = half @ np.concatenate([1.125 * eye, 0.125 * eye], axis=1)
        self._steep = half @ np.concatenate([1.125 * eye, 0.375 * eye], axis=1)

    def forward(self, m: Array, S: Array) -> tuple[Array, Array, Array, AngleWaves]:
        """Return mean and covariance of u, E[du/dr], shape (..., actions), and the tape."""
        angles = self._angles
        waves = waves_forward(m @ angles.T, angles @ S @ angles.T)
        sine, cosine = waves.single.imag, waves.single.real
        inner = 0.5 * (waves.difference.real - waves.sum.real)
        inner = inner - sine[..., :, None] * sine[..., None, :]
        mean = self._middle + sine @ self._share.T
        return mean, self._share @ inner @ self._share.T, cosine @ self._steep.T, waves

    def backward(
        self, tape: AngleWaves, mean: Array, covariance: Array, gain: Array
    ) -> tuple[Array, Array]:
        """Return the adjoints of m and S from those of what `forward` gave."""
        inner = self._share.T @ covariance @ self._share
        into_sine = mean @ self._share - _times(inner + inner.mT, tape.single.imag)
        wanted = AngleWaves(
            gain @ self._steep + 1j * into_sine, -0.5 * inner + 0.0j, 0.5 * inner + 0.0j
        )
        into_angle, into_spread = waves_backward(tape, wanted)
        return into_angle @ self._angles, self._angles.T @ into_spread @ self._angles


def _times(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])
