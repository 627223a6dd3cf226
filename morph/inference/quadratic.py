"""The log posterior of a hypothesis to second order about a point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array, Mask
from morph.inference.bounded import bounded
from morph.inference.columns import Columns
from morph.inference.observed import Observed
from morph.inference.whitened import Whitened, whitened_blocks
from morph.model.hypothesis import Hypothesis
from morph.sim.threads import each


@dataclass(frozen=True, kw_only=True, eq=False)
class LogPosterior:
    """Minus half of a sum of squares of whitened errors, and of the prior."""

    hypothesis: Hypothesis
    """Own parameters and effects."""
    point: Array
    """Where it is taken, shape (entries,)."""
    grams: Array
    """Gram matrices of [errors, entries], shape (folds, 1 + entries, 1 + entries)."""
    readings: int
    """How many readings there are."""

    def without_fold(self, fold: int) -> LogPosterior:
        """Return the quadratic of all folds but one."""
        return replace(self, grams=np.delete(self.grams, fold, axis=0))

    def inner(self) -> Array:
        """Return minus the second derivatives, shape (entries, entries)."""
        inner: Array = self.grams.sum(axis=0)[1:, 1:]
        return inner + np.diag(information(self.hypothesis))

    def along(self) -> Array:
        """Return the first derivatives, shape (entries,)."""
        pull: Array = self.grams.sum(axis=0)[1:, 0]
        return pull - information(self.hypothesis) * offset(self.hypothesis, self.point)

    def step(
        self, free: Mask | None = None, change: Array | None = None, damping: float = 0.0
    ) -> tuple[Array, int, float]:
        """Return the likeliest step, the rank of its columns and the nats that it gains.

        Args:
            free: Entries that it may move, shape (entries,); by default all.
            change: Change of the others, same shape; by default none.
            damping: Share of the second derivatives that is added to them, which shortens the
                step most where they are least. Source: Marquardt 1963, Journal of SIAM 11(2),
                eq. 18.
        """
        inner, pull = self.inner(), self.along()
        damped = inner + damping * np.diag(np.diag(inner))
        free = np.ones(len(pull), dtype=bool) if free is None else free
        whole = np.zeros_like(pull) if change is None else np.where(free, 0.0, change)
        low = self.hypothesis.low - self.point - 1e-9
        high = self.hypothesis.high - self.point + 1e-9
        left = (pull - inner @ whole)[free]
        whole[free], rank = bounded(damped[np.ix_(free, free)], left, low[free], high[free])
        return whole, rank, float(pull @ whole - 0.5 * whole @ inner @ whole)

    def evidence(self, kept: Sequence[int]) -> float:
        """Return the log evidence with some of the effects, the others at neutral, nats.

        It is that by Schwarz's criterion, up to a constant.

        Args:
            kept: Indices of the effects that stay.
        """
        _, rank, gained = self.step(*self._left(kept))
        extra = max(0, rank - self.hypothesis.free_knobs)
        return gained - 0.5 * extra * math.log(self.readings)

    def idle(self, kept: Sequence[int]) -> Array:
        """Return the likeliest point with some of the effects, the others at neutral, (entries,).

        Args:
            kept: Indices of the effects that stay.
        """
        free, change = self._left(kept)
        step, _, _ = self.step(free, change)
        best = np.clip(self.point + step, self.hypothesis.low, self.hypothesis.high)
        return np.where(free, best, self.point + change)

    def reduced(self, kept: Sequence[int]) -> tuple[Hypothesis, Array]:
        """Return the hypothesis with some of the effects alone, and its likeliest point."""
        fewer, entries = self.only(kept)
        return fewer, self.idle(kept)[entries]

    def only(self, kept: Sequence[int]) -> tuple[Hypothesis, Mask]:
        """Return the hypothesis with some of the effects alone, and which entries are its own."""
        effects = self.hypothesis.effects_at(self.point)
        fewer = replace(self.hypothesis, effects=tuple(effects[at] for at in kept))
        return fewer, self._left(kept)[0]

    def _left(self, kept: Sequence[int]) -> tuple[Mask, Array]:
        """Return which entries stay free, and how far the others are from neutral."""
        effects = self.hypothesis.effects_at(self.point)
        idle = [each if at in kept else each.neutral() for at, each in enumerate(effects)]
        own = len(self.hypothesis.knobs)
        stays = [at in kept for at, each in enumerate(effects) for _ in each.free()]
        change = np.zeros(len(self.point))
        change[own:] = (replace(self.hypothesis, effects=tuple(idle)).start - self.point)[own:]
        return np.array([True] * own + stays, dtype=bool), change


def quadratic(
    hypothesis: Hypothesis, point: Array, runs: Sequence[Observed], *, blocks: int = 1
) -> LogPosterior:
    """Return the log posterior to second order.

    Args:
        hypothesis: Own parameters and effects.
        point: Shape (entries,).
        runs: Smoothed and linearised there.
        blocks: Into how many folds each run is divided.
    """
    columns = Columns.of(hypothesis, point)

    def one(run: Observed) -> list[Whitened]:
        moved, shown = columns.along(run)
        about = run.about
        return whitened_blocks(about.tangent, about.disturbance, shown, moved, blocks=blocks)

    folds = [part for parts in each(one, runs) for part in parts]
    return LogPosterior(
        hypothesis=hypothesis,
        point=point,
        grams=np.stack([fold.gram for fold in folds]),
        readings=sum(fold.readings for fold in folds),
    )


def information(hypothesis: Hypothesis) -> Array:
    """Return one over the prior variance, zero where the prior is flat, shape (entries,)."""
    return np.where(np.isnan(hypothesis.likely), 0.0, hypothesis.trust)


def offset(hypothesis: Hypothesis, point: Array) -> Array:
    """Return a point less the prior mean, zero where the prior is flat, shape (entries,)."""
    return np.asarray(point - np.where(np.isnan(hypothesis.likely), point, hypothesis.likely))
