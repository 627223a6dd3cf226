"""Gaussian processes: functions known at some inputs, and how well they are known elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, solve_triangular

from morph.arrays import Array
from morph.errors import SearchError

CLEAREST = 1e-4
"""Least noise, as a share of the signal. A covariance of n inputs then has no eigenvalue below
1e-8 of the signal's variance, and rounding disturbs it by about n * 1e-16: its Cholesky
factorisation cannot fail."""

MOST_DATA = 2000
"""Most inputs; beyond, the covariance would not fit a small machine's memory and patience."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GaussianProcess:
    """Several functions of the same inputs, each a Gaussian process of its own.

    With s the signal, l the lengths and r the noise, two noisy values of a function have the
    covariance

        k(x, x') = s^2 exp(-1/2 sum over d of (x_d - x'_d)^2 / l_d^2) + r^2 [x and x' are one],

    and far from all inputs a function is expected to be 0.

    Source: Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, eqs. 2.23,
    2.24 and 5.1.

    Raises:
        SearchError: Shapes do not agree, a number is not finite, a setting is not positive, or
            the noise is too little.
    """

    inputs: Array
    """X, shape (n, d)."""
    targets: Array
    """Y, noisy values, shape (n, e)."""
    lengths: Array
    """l, in the inputs' units, shape (e, d)."""
    signal: Array
    """s, standard deviation of each function, in its unit, shape (e,)."""
    noise: Array
    """r, standard deviation of each target's noise, shape (e,)."""

    def __post_init__(self) -> None:
        """Check shapes and numbers."""
        check_data(self.inputs, self.targets)
        d, e = self.inputs.shape[1], self.targets.shape[1]
        parts = {"lengths": (e, d), "signal": (e,), "noise": (e,)}
        for name, shape in parts.items():
            value = getattr(self, name)
            if value.shape != shape or not (np.isfinite(value) & (value > 0.0)).all():
                raise SearchError(
                    f"its {name} have the shape {value.shape}, or are not all positive",
                    where="a Gaussian process",
                    fix=f"give positive numbers of shape {shape}",
                )
        if (self.noise < 0.999 * CLEAREST * self.signal).any():
            raise SearchError(
                f"its noise is {np.min(self.noise / self.signal):.1e} of its signal",
                where="a Gaussian process",
                fix=f"give at least {CLEAREST:g} of it",
            )

    @cached_property
    def factor(self) -> Array:
        """Lower Cholesky factor of the covariance of the noisy targets, shape (e, n, n)."""
        K = covariance(self.inputs, self.inputs, self.lengths, self.signal)
        at = np.arange(len(self.inputs))
        K[:, at, at] += (self.noise**2)[:, None]
        return np.asarray(np.linalg.cholesky(K), dtype=np.float64)

    @cached_property
    def weights(self) -> Array:
        """inv(K) Y, of which every prediction is made, shape (e, n)."""
        pairs = zip(self.factor, self.targets.T, strict=True)
        return np.stack([cho_solve((L, True), y) for L, y in pairs])

    @cached_property
    def precision(self) -> Array:
        """inv(K), shape (e, n, n)."""
        eye = np.eye(len(self.inputs))
        return np.stack([cho_solve((L, True), eye) for L in self.factor])

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return mean and variance of the functions, without noise, shape (m, e) each.

        Args:
            x: Inputs, shape (m, d).
        """
        k = covariance(x, self.inputs, self.lengths, self.signal)
        mean = (k @ self.weights[..., None])[..., 0].T
        known = [
            solve_triangular(L, each.T, lower=True) for L, each in zip(self.factor, k, strict=True)
        ]
        variance = self.signal**2 - np.stack([(each**2).sum(axis=0) for each in known], axis=1)
        return mean, np.maximum(variance, 0.0)

    def mean(self, x: Array) -> Array:
        """Return the mean of the functions at inputs (m, d), shape (m, e)."""
        k = covariance(x, self.inputs, self.lengths, self.signal)
        return np.asarray((k @ self.weights[..., None])[..., 0].T)

    def jacobian(self, x: Array) -> Array:
        """Return the derivative of the mean with respect to the inputs, shape (m, e, d)."""
        k = covariance(x, self.inputs, self.lengths, self.signal) * self.weights[:, None, :]
        # d/dx of k(x, x_i) is k (x_i - x) / l^2.
        slope = k @ self.inputs - k.sum(axis=-1, keepdims=True) * x
        return np.asarray(np.swapaxes(slope / self.lengths[:, None, :] ** 2, 0, 1))

    def with_data(self, inputs: Array, targets: Array) -> GaussianProcess:
        """Return the same functions with other data; lengths, signal and noise stay."""
        return GaussianProcess(
            inputs=inputs,
            targets=targets,
            lengths=self.lengths,
            signal=self.signal,
            noise=self.noise,
        )


def covariance(x: Array, y: Array, lengths: Array, signal: Array) -> Array:
    """Return s^2 exp(-|x - y|^2 / 2) of all pairs, lengths taken out, shape (e, m, n).

    Args:
        x: Shape (m, d).
        y: Shape (n, d).
        lengths: Shape (e, d).
        signal: Shape (e,).
    """
    # About a common middle the difference of squares loses fewest digits.
    middle = y.mean(axis=0)
    a, b = (x - middle) / lengths[:, None, :], (y - middle) / lengths[:, None, :]
    power = a @ np.swapaxes(b, -1, -2)
    power -= 0.5 * np.square(a).sum(axis=-1)[:, :, None]
    power -= 0.5 * np.square(b).sum(axis=-1)[:, None, :]
    np.minimum(power, 0.0, out=power)
    np.exp(power, out=power)
    power *= (signal**2)[:, None, None]
    return np.asarray(power)


def check_data(inputs: Array, targets: Array) -> None:
    """Check what a Gaussian process is to be made of.

    Raises:
        SearchError: There is too little or too much, shapes do not agree, or a number is not
            finite.
    """
    where = "the data of a Gaussian process"
    if inputs.ndim != 2 or targets.ndim != 2 or len(inputs) != len(targets):
        raise SearchError(
            f"inputs have the shape {inputs.shape}, and targets {targets.shape}",
            where=where,
            fix="give one row for each measurement, in both",
        )
    if not 2 <= len(inputs) <= MOST_DATA:
        raise SearchError(
            f"there are {len(inputs)} measurements",
            where=where,
            fix=f"give 2 to {MOST_DATA}; of more, a part that covers what was visited",
        )
    if not (np.isfinite(inputs).all() and np.isfinite(targets).all()):
        raise SearchError(
            "a measurement is no finite number",
            where=where,
            fix="leave out the trial in which a sensor failed",
        )
