"""What a Gaussian state is expected to cost, and its derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from morph.arrays import Array


@dataclass(frozen=True, kw_only=True)
class ExpectedCost:
    """The expected cost of an error e = A z + b that is linear in a Gaussian z.

    `saturating` costs 1 - exp(-|e|^2 / 2), of which with e ~ N(mu, C) is expected

        1 - |I + C|^-1/2 exp(-mu' inv(I + C) mu / 2),

    and `quadratic` costs |e|^2 / 2, of which is expected (|mu|^2 + tr C) / 2.

    Source: Deisenroth and Rasmussen 2011, PILCO, ICML, eqs. 24 and 25.
    """

    A: Array
    """Errors per state, in widths of the cost, shape (k, d)."""
    b: Array
    """The error at z = 0, shape (k,)."""
    weight: float = 1.0
    """What the cost is multiplied by."""
    norm: Literal["saturating", "quadratic"] = "saturating"
    """Which of the two."""

    def value(self, m: Array, S: Array) -> tuple[Array, Array, Array]:
        """Return the expected cost at z ~ N(m, S), and its derivatives in m and in S.

        Args:
            m: Shape (..., d).
            S: Shape (..., d, d).

        Returns:
            Shapes (...,), (..., d) and (..., d, d).
        """
        A = self.A
        mu, C = m @ A.T + self.b, A @ S @ A.T
        if self.norm == "quadratic":
            value = 0.5 * ((mu**2).sum(axis=-1) + np.trace(C, axis1=-2, axis2=-1))
            flat = np.broadcast_to(0.5 * A.T @ A, S.shape)
            return self.weight * value, self.weight * (mu @ A), self.weight * flat
        R = np.linalg.inv(np.eye(len(A)) + C)
        g = (R @ mu[..., None])[..., 0]
        left = self.weight * np.sqrt(np.linalg.det(R)) * np.exp(-0.5 * (g * mu).sum(axis=-1))
        into_mu = left[..., None] * g
        into_C = 0.5 * left[..., None, None] * (R - g[..., :, None] * g[..., None, :])
        return self.weight - left, into_mu @ A, A.T @ into_C @ A


def expected(costs: tuple[ExpectedCost, ...], m: Array, S: Array) -> tuple[Array, Array, Array]:
    """Return what all terms cost together at z ~ N(m, S), and its derivatives in m and in S.

    Shapes (...,), (..., d) and (..., d, d).
    """
    value, into_m, into_S = np.zeros(m.shape[:-1]), np.zeros_like(m), np.zeros_like(S)
    for cost in costs:
        more, first, second = cost.value(m, S)
        value, into_m, into_S = value + more, into_m + first, into_S + second
    return value, into_m, into_S
