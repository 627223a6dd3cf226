"""What data say of unknowns in a linear model with normal noise: a quadratic."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky

from morph.arrays import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Information:
    """A quadratic: log p(data | theta) = - (c - 2 b theta + theta H theta) / 2 + constant."""

    H: Array
    """Shape (unknowns, unknowns)."""
    b: Array
    """Shape (unknowns,)."""
    c: float
    """At theta = 0."""

    def __add__(self, other: Information) -> Information:
        """Return what independent data say together."""
        return Information(H=self.H + other.H, b=self.b + other.b, c=self.c + other.c)

    def weaker(self, factor: float) -> Information:
        """Return the information if every variance were greater by a factor."""
        return Information(H=self.H / factor, b=self.b / factor, c=self.c / factor)

    def missed(self, theta: Array) -> float:
        """Return the sum of squares that theta leaves, in units of the noise."""
        return float(self.c - 2.0 * self.b @ theta + theta @ self.H @ theta)

    def about(self, point: Array) -> Information:
        """Return the information on theta, where this is on theta less a point."""
        moved = self.H @ point
        return Information(
            H=self.H, b=self.b + moved, c=self.c + float(2.0 * self.b @ point + point @ moved)
        )

    def through(self, map_: Array) -> Information:
        """Return the information on w, where theta = map_ w; shape (unknowns, len(w))."""
        return Information(H=map_.T @ self.H @ map_, b=map_.T @ self.b, c=self.c)

    def with_prior(self, mean: Array, variance: Array) -> Information:
        """Return it with independent normal priors of the last unknowns as further data.

        Args:
            mean: Theirs, shape (k,) for k of the unknowns or all.
            variance: Likewise.
        """
        last, trust = slice(len(self.b) - len(mean), None), 1.0 / variance
        H, b = self.H.copy(), self.b.copy()
        H[last, last] += np.diag(trust)
        b[last] += trust * mean
        peak = float(mean @ (trust * mean)) + float(np.log(variance).sum())
        return Information(H=H, b=b, c=self.c + peak)

    @cached_property
    def factor(self) -> Array:
        """Lower Cholesky factor of H.

        Raises:
            numpy.linalg.LinAlgError: H is not positive definite.
        """
        return np.asarray(cholesky(self.H, lower=True))

    @cached_property
    def mean(self) -> Array:
        """The likeliest theta, shape (unknowns,)."""
        return np.asarray(cho_solve((self.factor, True), self.b))

    @property
    def log_evidence(self) -> float:
        """Log p(data), theta integrated out, where a prior is part of it; Laplace, eq. 2.6.

        Source: MacKay 1992, Neural Computation 4(3), Bayesian interpolation.
        """
        twice = self.c - float(self.b @ self.mean)
        return -0.5 * (twice + 2.0 * float(np.log(np.diag(self.factor)).sum()))

    def drawn(self, count: int, rng: np.random.Generator, scale: float = 1.0) -> Array:
        """Return draws from the posterior, shape (count, unknowns).

        Args:
            count: How many.
            rng: Random numbers.
            scale: What the standard deviations are multiplied by.
        """
        # inv(L') z has the covariance inv(L L').
        chance = rng.normal(size=(len(self.b), count))
        return np.asarray(self.mean + scale * np.linalg.solve(self.factor.T, chance).T)

    def first(self, count: int) -> tuple[Information, Array]:
        """Return what it says of the first unknowns, the others integrated out.

        Source: Schur's complement; Rasmussen and Williams 2006, eq. 2.43 for the mixed model.

        Returns:
            The information, and the covariance of the others given the first.
        """
        H, b, p = self.H, self.b, count
        inner = np.asarray(np.linalg.inv(H[p:, p:]), dtype=float)
        cross = H[:p, p:] @ inner
        occam = float(np.linalg.slogdet(H[p:, p:])[1])
        return Information(
            H=H[:p, :p] - cross @ H[p:, :p],
            b=b[:p] - cross @ b[p:],
            c=self.c - float(b[p:] @ inner @ b[p:]) + occam,
        ), inner
