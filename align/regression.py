"""A function of few data: a linear law, and beside it a smooth rest that fades out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, solve_triangular
from scipy.optimize import minimize

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError

MOST_DATA = 1500
"""Most data; beyond, the covariance asks for more than a small machine's patience."""

WIDEST = 7.0
"""How far the logarithm of a setting may be from 0, in units of the data's spread."""

CLEAREST = 1e-3
"""Least noise, as a share of the targets' spread, so that covariances can be factorised."""

PRIORS = ((-0.7, 1.0), (-1.0, 1.0), (1.0, 0.5), (-1.5, 1.5))
"""Middle and standard deviation of the logarithms of a, s, l and r, the targets' root mean square
being 1: a law as large as the data, a rest somewhat smaller, and smooth."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Regression:
    """One output of the same inputs: y = b + w z + f(z) + noise, z being x / scale.

    The law b + w z has independent normal weights of standard deviation a; the rest f is a
    Gaussian process with covariance s^2 exp(-|z - z'|^2 / (2 l^2)), which is expected to be 0
    far from all data, where the law alone goes on.

    Source: Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, section 2.7.
    """

    inputs: Array
    """X, shape (n, d)."""
    targets: Array
    """y, shape (n,)."""
    scale: Array
    """What inputs are divided by, shape (d,)."""
    law: float
    """a, in the target's unit."""
    signal: float
    """s, in the target's unit."""
    length: float
    """l, in scales."""
    noise: Array
    """r, standard deviation of each datum's noise, shape (n,)."""

    @cached_property
    def _z(self) -> Array:
        return np.asarray(self.inputs / self.scale)

    @cached_property
    def _factor(self) -> Array:
        K = self.covariance(self._z) + np.diag(self.noise**2)
        return np.asarray(np.linalg.cholesky(K))

    @cached_property
    def _weights(self) -> Array:
        return np.asarray(cho_solve((self._factor, True), self.targets))

    def covariance(self, z: Array) -> Array:
        """Return the covariance of scaled inputs (m, d) with the data, shape (m, n)."""
        rest = self.signal**2 * np.exp(-0.5 * apart(z, self._z) / self.length**2)
        return np.asarray(rest + self.law**2 * (1.0 + z @ self._z.T))

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return mean and variance of the function, without noise, shape (m,) each.

        Args:
            x: Inputs, shape (m, d).
        """
        z = np.asarray(x / self.scale)
        k = self.covariance(z)
        known = solve_triangular(self._factor, k.T, lower=True)
        before = self.signal**2 + self.law**2 * (1.0 + np.square(z).sum(axis=1))
        variance = np.asarray(before - np.square(known).sum(axis=0))
        return np.asarray(k @ self._weights), np.maximum(variance, 0.0)

    @cached_property
    def linear(self) -> Array:
        """The constant b, and then w per unit of each input, shape (1 + d,)."""
        b = self.law**2 * float(self._weights.sum())
        w = self.law**2 * (self._weights @ self._z) / self.scale
        return np.concatenate([[b], w])

    @cached_property
    def bumps(self) -> tuple[Array, Array, Array]:
        """The rest as a sum of radial functions at the data.

        Centres (n, d), their width in each input's unit (d,), and their weights (n,).
        """
        return self.inputs, self.length * self.scale, self.signal**2 * self._weights


def apart(z: Array, other: Array) -> Array:
    """Return the squared distance of all pairs, shape (m, n)."""
    square = np.square(z).sum(axis=1)[:, None] + np.square(other).sum(axis=1)
    return np.asarray(np.maximum(square - 2.0 * z @ other.T, 0.0))


def regression(inputs: Array, targets: Array, variance: Array | None = None) -> Regression:
    """Return the function that the data make most probable.

    Inputs are scaled by their root mean square and not moved, so that a law through the origin,
    as friction is, costs no constant. The four settings are found by L-BFGS on the log evidence
    under wide priors, with its gradient in closed form.

    Source: Rasmussen and Williams 2006, eqs. 5.8 and 5.9.

    Args:
        inputs: Shape (n, d).
        targets: Shape (n,).
        variance: Known variance of each datum beside its common noise, shape (n,); None for 0.

    Raises:
        SamplesError: The data are too few, too many, unequal in number, or no numbers.
    """
    check_samples(inputs, targets)
    scale = np.sqrt(np.square(inputs).mean(axis=0))
    scale = np.where(scale > 1e-9, scale, 1.0)
    high = max(float(np.sqrt(np.square(targets).mean())), 1e-9)
    known = np.zeros(len(targets)) if variance is None else variance / high**2
    problem = _Evidence(inputs / scale, targets / high, known)
    starts = [np.array([a, s, 1.0, -1.5]) for a, s in ((0.0, -1.0), (-2.0, 0.0))]
    runs = [
        minimize(
            problem,
            start,
            jac=True,
            method="L-BFGS-B",
            bounds=[(-WIDEST, WIDEST)] * 4,
            options={"maxiter": 60},
        )
        for start in starts
    ]
    law, signal, length, noise = np.exp(min(runs, key=lambda run: float(run.fun)).x)
    total = np.sqrt(noise**2 + CLEAREST**2 + known) * high
    return Regression(
        inputs=inputs,
        targets=targets,
        scale=scale,
        law=float(law * high),
        signal=float(signal * high),
        length=float(length),
        noise=np.asarray(total),
    )


def check_samples(inputs: Array, targets: Array) -> None:
    """Check that there are enough numbers, and as many targets as inputs.

    Raises:
        SamplesError: There are not.
    """
    where = "the data of a regression"
    if inputs.ndim != 2 or len(inputs) != len(targets):
        raise SamplesError(
            f"inputs have the shape {inputs.shape}, and targets {targets.shape}",
            where=where,
            fix="give one row for each measurement, in both",
        )
    if not 3 <= len(inputs) <= MOST_DATA:
        raise SamplesError(
            f"there are {len(inputs)} measurements",
            where=where,
            fix=f"give 3 to {MOST_DATA}; of more, every second or third",
        )
    if not (np.isfinite(inputs).all() and np.isfinite(targets).all()):
        raise SamplesError(
            "a measurement is no finite number",
            where=where,
            fix="leave out what a sensor failed to see",
        )


class _Evidence:
    """Minus the log evidence with the log prior, and its gradient, in the logs of a, s, l, r."""

    def __init__(self, z: Array, y: Array, known: Array) -> None:
        self.y, self.known = y, known
        self.linear, self.square = 1.0 + z @ z.T, apart(z, z)
        self.middle, self.width = np.array(PRIORS).T

    def __call__(self, logs: Array) -> tuple[float, Array]:
        a, s, length, r = np.exp(2.0 * logs)
        law, rest = a * self.linear, s * np.exp(-0.5 * self.square / length)
        K = law + rest + np.diag(r + CLEAREST**2 + self.known)
        factor = np.linalg.cholesky(K)
        inverse = cho_solve((factor, True), np.eye(len(K)))
        weight = inverse @ self.y
        value = 0.5 * self.y @ weight + np.log(np.diag(factor)).sum()
        value += 0.5 * len(K) * math.log(2.0 * math.pi)
        # d/dt of minus the log evidence is 1/2 tr((inv(K) - w w') dK/dt); K holds squares.
        G = inverse - np.outer(weight, weight)
        slope = np.array(
            [(G * law).sum(), (G * rest).sum(), 0.5 * (G * rest * self.square).sum() / length]
        )
        slope = np.append(slope, r * np.trace(G))
        off = (logs - self.middle) / self.width
        return float(value) + 0.5 * float(off @ off), slope + off / self.width
