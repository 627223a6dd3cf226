"""The policies whose moments have a closed form: linear and radial."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.arrays import Array
from morph.search.gp_rollout.belief import ControlLaw
from morph.search.moments.moment_matching_rff import Squasher
from morph.search.moments.moments import Moments
from morph.search.moments.radial import RadialNumbers, radial_backward, radial_forward


class LinearLaw(ControlLaw):
    """r = K x + b.

    Args:
        gain: K, shape (..., actions, features).
        bias: b, shape (..., actions).
    """

    def __init__(self, gain: Array, bias: Array) -> None:
        self.gain, self.bias = gain, bias

    def forward(self, m: Array, S: Array) -> tuple[Moments, Any]:
        """Return the moments, which are those of any linear map."""
        K = self.gain
        mean = (K @ m[..., None])[..., 0] + self.bias
        return Moments(mean, K @ S @ K.mT, np.broadcast_to(K, (*m.shape[:-1], *K.shape[-2:]))), (
            m,
            S,
        )

    def backward(
        self, tape: Any, mean: Array, covariance: Array, slope: Array
    ) -> tuple[Array, Array, Array]:
        """Return the adjoints; of the numbers first those of K, then those of b."""
        m, S = tape
        both = covariance + covariance.mT
        into_gain = mean[..., :, None] * m[..., None, :] + both @ self.gain @ S + slope
        into_S = self.gain.mT @ (0.5 * both) @ self.gain
        flat = into_gain.reshape(*mean.shape[:-1], -1)
        into_m = (mean[..., None, :] @ self.gain)[..., 0, :]
        return into_m, into_S, np.concatenate([flat, mean], axis=-1)


class RadialLaw(ControlLaw):
    """Radial basis functions.

    Args:
        numbers: Centres, logarithms of widths, and weights.
    """

    def __init__(self, numbers: RadialNumbers) -> None:
        self.numbers = numbers

    def forward(self, m: Array, S: Array) -> tuple[Moments, Any]:
        """Return the moments."""
        return radial_forward(self.numbers, m, S)

    def backward(
        self, tape: Any, mean: Array, covariance: Array, slope: Array
    ) -> tuple[Array, Array, Array]:
        """Return the adjoints; of the numbers those of centres, widths and weights in turn."""
        into_m, into_S, numbers = radial_backward(tape, mean, covariance, slope)
        flat = [
            each.reshape(*mean.shape[:-1], -1)
            for each in (numbers.centre, numbers.width, numbers.weight)
        ]
        return into_m, into_S, np.concatenate(flat, axis=-1)


class Unsquashed(Squasher):
    """Commands that are the law's numbers as they are."""

    def forward(self, m: Array, S: Array) -> tuple[Array, Array, Array, Any]:
        """Return mean, covariance and slope 1."""
        return m, S, np.ones_like(m), None

    def backward(
        self, tape: Any, mean: Array, covariance: Array, gain: Array
    ) -> tuple[Array, Array]:
        """Return the adjoints, which pass through."""
        return mean, covariance
