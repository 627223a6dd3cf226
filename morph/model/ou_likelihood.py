"""Likelihood of transitions under an unmodelled Ornstein-Uhlenbeck force (Kalman filter).

A model's errors along a run are not independent: noise on a state spoils the transitions on
both sides of it, and what a model leaves out (a current, a drag that is off) lasts. Both are told
here by one linear model with normal noise, whose likelihood a Kalman filter gives exactly, in
time that grows with the run as a straight line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.filter import innovations


@dataclass(frozen=True, kw_only=True, eq=False)
class Likelihood:
    """log p(run | theta) = base + slope . theta - theta . curve theta / 2, for many settings.

    theta are the figures in doubt, by their standard deviations; there may be none.
    """

    base: Array
    """With every doubtful figure as the model has it, shape (models, settings, ...)."""
    slope: Array
    """Shape (models, settings, ..., doubts)."""
    curve: Array
    """Shape (models, settings, ..., doubts, doubts)."""

    def __add__(self, other: Likelihood) -> Likelihood:
        """Return that of two runs together."""
        return Likelihood(
            base=self.base + other.base,
            slope=self.slope + other.slope,
            curve=self.curve + other.curve,
        )

    def until(self, samples: int | Sequence[int]) -> Likelihood:
        """Return that of a run's first samples, where the third axis counts samples from 1."""
        at: Any = np.asarray(samples) - 1
        return Likelihood(
            base=self.base[:, :, at], slope=self.slope[:, :, at], curve=self.curve[:, :, at]
        )


def likelihood(
    miss: Array,
    carry: Array,
    *,
    doubt: Array,
    noise: Array,
    leak: Array,
    scale: Array,
    length: Array,
    period: float,
) -> Likelihood:
    """Return how probable transitions are, up to each, for many settings at once.

    The error of the observation, delta = x - y, and the acceleration a that the model leaves out:

        delta(t+1) = miss(t) + doubt(t) theta + carry(t) delta(t) + (h^2 / 2, h) a(t) + leak,
        a(t+1) = phi a(t) + sqrt(1 - phi^2) scale w,   phi = exp(-h / length),   -delta(t) = noise,

    a being the Ornstein-Uhlenbeck process: a Gaussian process with the kernel
    scale^2 exp(-|t - t'| / length).

    Source: Rasmussen and Williams 2006, Gaussian processes for machine learning, appendix B (the
    kernel).

    Args:
        miss: As `Transitions` have it, shape (models, periods, 2 m).
        carry: Likewise, shape (models or 1, periods, 2 m, 2 m).
        doubt: Likewise, shape (models, periods, 2 m, doubts).
        noise: Standard deviation of each observed number, shape (2 m,).
        leak: Variance that other parts of the state pour in, shape (models or 1, periods, 2 m).
        scale: Of the acceleration left out, in each setting, shape (settings, m).
        length: For how long it lasts, s, shape (settings,).
        period: h, s.

    Returns:
        The likelihood up to each sample, (models, settings, periods).
    """
    models, periods, n = miss.shape
    m, settings, doubts = n // 2, len(scale), doubt.shape[-1]
    size = n + m
    keep = np.exp(-period / length)
    # Models that share a carry share its spreads too, which are most of the work.
    step = np.zeros((len(carry), settings, size, size))
    step[..., :m, n:] = 0.5 * period**2 * np.eye(m)
    step[..., m:n, n:] = period * np.eye(m)
    step[..., n:, n:] = keep[:, None, None] * np.eye(m)
    added = np.zeros((len(carry), settings, size))
    added[..., n:] = scale**2 * (1.0 - keep**2)[:, None]
    moves = np.zeros((models, settings, size, 1 + doubts))
    # The first state is known by its observation alone, and its error is the noise.
    spread = np.zeros((len(carry), settings, size, size))
    diagonal = np.arange(size)
    spread[..., diagonal[:n], diagonal[:n]] = noise**2
    spread[..., diagonal[n:], diagonal[n:]] = scale**2

    def transitions() -> Iterator[tuple[Array, Array, Array]]:
        for t in range(periods):
            step[..., :n, :n] = carry[:, t, None]
            added[..., :n] = leak[:, t, None]
            moves[..., :n, 0], moves[..., :n, 1:] = miss[:, t, None], doubt[:, t, None]
            yield step, moves, added

    base = np.empty((models, settings, periods))
    square = np.empty((models, settings, periods, 1 + doubts, 1 + doubts))
    for t, (surprise, peak) in enumerate(innovations(spread, transitions(), noise)):
        square[..., t, :, :] = np.swapaxes(surprise, -1, -2) @ surprise
        base[..., t] = peak
    base -= 0.5 * square[..., 0, 0]
    return Likelihood(
        base=np.cumsum(base, axis=2),
        slope=np.cumsum(-square[..., 0, 1:], axis=2),
        curve=np.cumsum(square[..., 1:, 1:], axis=2),
    )
