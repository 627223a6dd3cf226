"""How fast each pattern goes, as far as trials tell: what one body's trials say of the next."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array

SCALE = 0.2
"""How far in the cube two patterns are alike."""

PRIOR = 0.3
"""Standard deviation of what a body does unlike what was foreseen, in shares of the best."""

NOISE = 0.02
"""Standard deviation of what the smooth surface cannot say, in shares of the best."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Landscape:
    """A Gaussian process of shares of the best speed over the cube, about what was foreseen.

    mean(x) = foreseen(x) + k(x) (K + s^2 I)^-1 (y - foreseen): another body's landscape is
    foreseen, or nothing. Kernel: exp(-d^2 / (2 SCALE^2)).

    Source: Cully, Clune, Tarapore and Mouret 2015, Robots that can adapt like animals,
    Nature 521, eq. 2 to 4: trials on one body corrected by few on another.
    """

    point: Array
    """What was tried, points of the cube, shape (trials, numbers)."""
    share: Array
    """How fast each went, over the best, shape (trials,)."""
    foreseen: Landscape | None = None
    """What was thought before; zero if there is none."""
    prior: float = PRIOR
    """Standard deviation before a trial."""

    def mean(self, point: Array) -> Array:
        """Return the shares that are to be expected at points (m, numbers), shape (m,)."""
        before = self._before(point)
        if not len(self.point):
            return before
        return np.asarray(before + self._kernel(point) @ self._solved)

    def spread(self, point: Array) -> Array:
        """Return the standard deviations there, shape (m,)."""
        if not len(self.point):
            return np.full(len(point), self.prior)
        cross = self._kernel(point)
        known = np.einsum("mi,ij,mj->m", cross, self._inverse, cross)
        return np.asarray(np.sqrt(np.maximum(self.prior**2 - known, 1e-9)))

    def promise(self, point: Array) -> Array:
        """Return how much better than the best of the trials is to be expected, shape (m,).

        Source: Jones, Schonlau and Welch 1998, Efficient global optimization of expensive
        black-box functions, J. Global Optimization 13, eq. 15: expected improvement.
        """
        from scipy.special import ndtr

        mean, spread = self.mean(point), self.spread(point)
        best = float(self.share.max()) if len(self.share) else 0.0
        z = (mean - best) / spread
        bell = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
        return np.asarray((mean - best) * ndtr(z) + spread * bell)

    def _before(self, point: Array) -> Array:
        return np.zeros(len(point)) if self.foreseen is None else self.foreseen.mean(point)

    @cached_property
    def _inverse(self) -> Array:
        noise = NOISE**2 * np.eye(len(self.point))
        return np.asarray(np.linalg.inv(self._kernel(self.point) + noise))

    @cached_property
    def _solved(self) -> Array:
        return np.asarray(self._inverse @ (self.share - self._before(self.point)))

    def _kernel(self, point: Array) -> Array:
        return np.asarray(self.prior**2 * np.exp(-0.5 * self._apart(point, self.point) / SCALE**2))

    def _apart(self, one: Array, other: Array) -> Array:
        return np.asarray(((one[:, None] - other[None]) ** 2).sum(axis=2))
