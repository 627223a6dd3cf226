"""Columns whitened under one scale of the missing force, and effects fitted by them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.inference.bounded import RANK_TOLERANCE, bounded
from morph.inference.streaming import resolved
from morph.physics.effect import Effect


@dataclass(frozen=True, kw_only=True, eq=False)
class EffectColumn:
    """One effect at one shape, an entry of the dictionary."""

    effect: Effect
    """The effect at that shape."""
    place: slice
    """Its columns, one a strength, of a Gram matrix of [errors, effects] without own parameters."""

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """The least and the greatest of its coefficients, a little wider: equal ones leave room."""
        low, high = self.effect.coefficient_bounds()
        return low - 1e-12, high + 1e-12

    @cached_property
    def label(self) -> str:
        """That of the effect."""
        return self.effect.label


@dataclass(frozen=True, kw_only=True, eq=False)
class LevelFit:
    """Own parameters and effects at their likeliest under one scale of the missing force."""

    effects: tuple[Effect, ...]
    """With their strengths."""
    evidence: float
    """Log evidence less prices, nats, up to a constant of the readings."""
    own: Array
    """Change of each own parameter, shape (own,)."""
    held: Mask
    """Which of them are at a bound, same shape."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WhitenedLevel:
    """Columns [errors, own parameters, effects], whitened under one scale of the missing force.

    Own parameters are those of the description and the parameters of effects found before.
    """

    gram: Array
    """Their Gram matrix, with the prior of own parameters as readings; shape (columns, columns)."""
    logarithm: float
    """Logarithm of the determinant of the readings' covariance."""
    low: Array
    """Least change of each own parameter, shape (own,)."""
    high: Array
    """Greatest change, same shape."""
    folds: tuple[Array, ...] = ()
    """The part of each fold of the readings in the Gram matrix."""

    def without_fold(self, fold: int) -> WhitenedLevel:
        """Return the columns over all folds but one."""
        return replace(self, gram=self.gram - self.folds[fold])

    def fixed(self, entries: Integers, change: Array) -> WhitenedLevel:
        """Return the columns without some own parameters, which change by known amounts.

        Args:
            entries: Indices of the own parameters.
            change: Of each, shape (len(entries),).
        """
        turn = np.eye(len(self.gram))
        turn[1 + entries, 0] = -change
        turn = np.delete(turn, 1 + entries, axis=1)
        low, high = (np.delete(each, entries) for each in (self.low, self.high))
        return replace(self, gram=turn.T @ self.gram @ turn, low=low, high=high, folds=())

    def rest(self, held: Mask) -> Array:
        """Return the Gram matrix of [errors, effects] with the free own parameters projected out.

        It is the Schur complement of their block.

        Args:
            held: Own parameters that stay as they are, shape (own,).
        """
        count = len(self.low)
        own, kept = 1 + np.flatnonzero(~held), np.r_[0, 1 + count : len(self.gram)]
        across = self.gram[np.ix_(own, kept)]
        inner = self.gram[np.ix_(own, own)]
        return projected(self.gram[np.ix_(kept, kept)], inner, across)

    def fit(self, columns: Sequence[EffectColumn], readings: int, prior: float) -> LevelFit:
        """Return own parameters and effects at their likeliest, all within their bounds.

        Source: Schwarz 1978, Annals of Statistics 6(2), 461-464 (the price of a column).

        Args:
            columns: The effects.
            readings: How many readings there are.
            prior: Negative log prior of the effects together, nats.
        """
        count = len(self.low)
        effects = tuple(column.effect for column in columns)
        places = [np.r_[column.place] + count for column in columns]
        low, high = all_bounds(columns)
        low, high = np.concatenate([self.low, low]), np.concatenate([self.high, high])
        chosen = np.concatenate([np.arange(1, 1 + count), *places]).astype(int)
        inner, along = self.gram[np.ix_(chosen, chosen)], self.gram[chosen, 0]
        best, rank = bounded(inner, along, low, high)
        ends = np.cumsum([count, *(len(place) for place in places)])[:-1]
        own, *parts = np.split(best, ends)
        # Where an effect clips a strength or couples it to its shape, the coefficients differ from
        # the fitted ones: refit the own parameters beside them.
        effects = tuple(e.with_strengths(part) for e, part in zip(effects, parts, strict=True))
        strengths = np.concatenate([best[:0], *(effect.coefficients for effect in effects)])
        if not np.allclose(strengths, best[count:], rtol=1e-6):
            left = along[:count] - inner[:count, count:] @ strengths
            own, _ = bounded(inner[:count, :count], left, self.low, self.high)
        whole = np.concatenate([own, strengths])
        square = self.gram[0, 0] - 2.0 * along @ whole + whole @ inner @ whole
        price = 0.5 * (rank - count) * math.log(readings) + prior
        slack = 1e-3 * (self.high - self.low)
        return LevelFit(
            effects=resolved(effects),
            evidence=-0.5 * float(square + self.logarithm) - price,
            own=own,
            held=(own < self.low + slack) | (own > self.high - slack),
        )


def projected(gram: Array, inner: Array, across: Array) -> Array:
    """Return a Gram matrix with some columns projected out, those that depend on others once.

    Columns of which no more than rounding is left become zero.

    Args:
        gram: The matrix, shape (columns, columns).
        inner: That of the columns to project out, shape (some, some).
        across: Their inner products with all, shape (some, columns).
    """
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    inverse = np.linalg.pinv(inner / np.outer(scale, scale), rcond=RANK_TOLERANCE, hermitian=True)
    across = across / scale[:, None]
    rest = gram - across.T @ inverse @ across
    gone = np.diag(rest) < RANK_TOLERANCE * np.diag(gram)
    gone[0] = False
    rest[gone] = rest[:, gone] = 0.0
    return np.asarray(rest)


def all_bounds(columns: Sequence[EffectColumn]) -> tuple[Array, Array]:
    """Return the bounds of the columns of some effects."""
    pairs = [(np.zeros(0), np.zeros(0)), *(column.bounds for column in columns)]
    low, high = zip(*pairs, strict=True)
    return np.concatenate(low), np.concatenate(high)
