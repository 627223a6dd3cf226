"""How fast each pattern goes, as far as trials tell: what one body's trials say of the next."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from morph.arrays import Array

if TYPE_CHECKING:
    from sklearn.gaussian_process import GaussianProcessRegressor

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
        return np.asarray(self._before(point) + self._process.predict(point))

    def spread(self, point: Array) -> Array:
        """Return the standard deviations there, shape (m,)."""
        return np.asarray(self._process.predict(point, return_std=True)[1])

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
    def _process(self) -> GaussianProcessRegressor:
        """The process of what trials went beyond what was foreseen."""
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel

        kernel = ConstantKernel(self.prior**2, "fixed") * RBF(SCALE, "fixed")
        process = GaussianProcessRegressor(kernel, alpha=NOISE**2, optimizer=None)
        if len(self.point):
            process.fit(self.point, self.share - self._before(self.point))
        return process
