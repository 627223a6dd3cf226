"""Estimate how much of the commanded force acts on a live target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.policy_transfer.live.delay import responses
from morph.sim.simulator import Simulator

SURELY = 3.0
"""Standard errors that make a share certain."""

HALF = 0.5
"""A share must surely be below it to be called none: a run that hardly tells is no sign."""

LITTLE = 0.05
"""A share that is as good as none: a body ten times as heavy as described shows 0.1."""


@dataclass(frozen=True, kw_only=True)
class Heed:
    """What share of the commands' effect is seen."""

    share: float
    """1 of a body that does as its model, 0 of one that heeds no command."""
    error: float
    """Its standard error."""

    @property
    def ignored(self) -> bool:
        """Whether nothing of the commands is seen, and at least half of them would have been."""
        off = SURELY * self.error
        return abs(self.share) <= max(off, LITTLE) and abs(self.share) + off < HALF

    @property
    def opposite(self) -> bool:
        """Whether the body surely does the opposite of what it is told."""
        return self.share < -max(SURELY * self.error, LITTLE)


def heed_of(
    simulator: Simulator, position: Array, velocity: Array, command: Array, period: float
) -> Heed | None:
    """Return what share of the commands' effect a run shows; None if it does not tell.

    The changes of velocity that the model has not without commands are fitted by what commands
    would have added, at each delay a weight; the share is their sum. The arguments are those of
    `delay_of`. A heavy body does a small share, and surely more than none.
    """
    result = responses(simulator, position, velocity, command, period)
    if result is None:
        return None
    left, effect = result
    moved = effect.std(axis=(0, 1)) > 1e-9
    scale = np.where(moved & (left.std(axis=0) > 1e-12), left.std(axis=0), np.inf)
    y = ((left - left.mean(axis=0)) / scale).ravel()
    columns = (effect - effect.mean(axis=1, keepdims=True)) / scale
    X = columns.reshape(len(effect), -1).T
    gram = X.T @ X
    if not (np.isfinite(gram).all() and np.isfinite(y).all()) or np.linalg.cond(gram) > 1e8:
        return None
    weight = np.linalg.solve(gram, X.T @ y)
    rest = y - X @ weight
    scatter = float(rest @ rest) / max(len(y) - len(weight), 1)
    ones = np.ones(len(weight))
    error = float(np.sqrt(scatter * ones @ np.linalg.solve(gram, ones)))
    return Heed(share=float(weight.sum()), error=error)
