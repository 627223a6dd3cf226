"""Beam search for sets of effects by the Gram matrix of their columns; nothing is simulated."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.inference.bounded import RANK_TOLERANCE, bounded
from morph.physics.effect import Effect

BEAM_WIDTH, BRANCHES = 6, 12
"""How many sets of one size are grown, and by how many effects each set is, one at a time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """One effect at one shape, an entry of the dictionary."""

    effect: Effect
    """The effect at that shape."""
    place: slice
    """Its columns, one a strength, of a Gram matrix of [errors, effects] without own figures."""


@dataclass(frozen=True, kw_only=True)
class Prior:
    """How probable sets of effects are before any run, as prices: negative logarithms, nats."""

    alone: Mapping[str, float]
    """Price of each effect, by its label."""
    together: tuple[tuple[frozenset[str], float], ...] = ()
    """Labels of effects that come together, as one law at every joint, and the price of them all;
    larger groups first."""

    def price(self, labels: Collection[str]) -> float:
        """Return the price of a set of effects."""
        left, price = set(labels), 0.0
        for group, whole in self.together:
            if group <= left and whole < sum(self.alone[label] for label in group):
                left, price = left - group, price + whole
        return price + sum(self.alone[label] for label in left)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fit:
    """Own figures and effects at their likeliest under one scale of the missing force."""

    effects: tuple[Effect, ...]
    """With their strengths."""
    evidence: float
    """Log evidence less prices, nats, up to a constant of the readings."""
    own: Array
    """Change of each own figure, shape (own,)."""
    held: Mask
    """Which of them are at a bound, same shape."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Level:
    """Columns [errors, own figures, effects], whitened under one scale of the missing force.

    Own figures are those of the description and the parameters of effects found before.
    """

    gram: Array
    """Their Gram matrix, with the prior of own figures as readings; shape (columns, columns)."""
    logarithm: float
    """Logarithm of the determinant of the readings' covariance."""
    low: Array
    """Least change of each own figure, shape (own,)."""
    high: Array
    """Greatest change, same shape."""
    folds: tuple[Array, ...] = ()
    """The part of each fold of the readings in the Gram matrix."""

    def without_fold(self, fold: int) -> Level:
        """Return the columns over all folds but one."""
        return replace(self, gram=self.gram - self.folds[fold])

    def fixed(self, entries: Integers, change: Array) -> Level:
        """Return the columns without some own figures, which change by known amounts.

        Args:
            entries: Indices of the own figures.
            change: Of each, shape (len(entries),).
        """
        turn = np.eye(len(self.gram))
        turn[1 + entries, 0] = -change
        turn = np.delete(turn, 1 + entries, axis=1)
        low, high = (np.delete(each, entries) for each in (self.low, self.high))
        return replace(self, gram=turn.T @ self.gram @ turn, low=low, high=high, folds=())

    def rest(self, held: Mask) -> Array:
        """Return the Gram matrix of [errors, effects] with the free own figures projected out.

        It is the Schur complement of their block.

        Args:
            held: Own figures that stay as they are, shape (own,).
        """
        count = len(self.low)
        own, kept = 1 + np.flatnonzero(~held), np.r_[0, 1 + count : len(self.gram)]
        across = self.gram[np.ix_(own, kept)]
        inner = self.gram[np.ix_(own, own)]
        return _projected(self.gram[np.ix_(kept, kept)], inner, across)

    def fit(self, columns: Sequence[Column], readings: int, prior: float) -> _Fit:
        """Return own figures and effects at their likeliest, all within their bounds.

        Source: Schwarz 1978, Annals of Statistics 6(2), 461-464 (the price of a column).

        Args:
            columns: The effects.
            readings: How many readings there are.
            prior: Negative log prior of the effects together, nats.
        """
        count = len(self.low)
        effects = tuple(column.effect for column in columns)
        places = [np.r_[column.place] + count for column in columns]
        low, high = _all_bounds(effects)
        low, high = np.concatenate([self.low, low]), np.concatenate([self.high, high])
        chosen = np.concatenate([np.arange(1, 1 + count), *places]).astype(int)
        inner, along = self.gram[np.ix_(chosen, chosen)], self.gram[chosen, 0]
        best, rank = bounded(inner, along, low, high)
        ends = np.cumsum([count, *(len(place) for place in places)])[:-1]
        own, *parts = np.split(best, ends)
        # Where an effect clips a strength or couples it to its shape, the coefficients differ from
        # the fitted ones: refit the own figures beside them.
        effects = tuple(e.with_strengths(part) for e, part in zip(effects, parts, strict=True))
        strengths = np.concatenate([best[:0], *(effect.coefficients for effect in effects)])
        if not np.allclose(strengths, best[count:], rtol=1e-6):
            left = along[:count] - inner[:count, count:] @ strengths
            own, _ = bounded(inner[:count, :count], left, self.low, self.high)
        whole = np.concatenate([own, strengths])
        square = self.gram[0, 0] - 2.0 * along @ whole + whole @ inner @ whole
        price = 0.5 * (rank - count) * math.log(readings) + prior
        slack = 1e-3 * (self.high - self.low)
        return _Fit(
            effects=effects,
            evidence=-0.5 * float(square + self.logarithm) - price,
            own=own,
            held=(own < self.low + slack) | (own > self.high - slack),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Explanation:
    """A set of effects at its likeliest strengths, and own figures refitted beside it."""

    effects: tuple[Effect, ...]
    """None, one or several, each at the best shape of its grid."""
    gain: float
    """Log evidence less that of no effect, less prices, nats."""
    own: Array
    """Change of each entry of the point about which the runs are linearised, shape (own,)."""
    members: tuple[int, ...]
    """Its entries of the dictionary."""
    level: int
    """The scale of the missing force at which it is likeliest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Search:
    """A beam search for sets of effects."""

    columns: tuple[Column, ...]
    """The dictionary."""
    levels: tuple[Level, ...]
    """One for each scale of the missing force."""
    readings: int
    """How many readings there are."""
    prior: Prior
    """How probable sets are beforehand."""
    known: frozenset[str] = frozenset()
    """Labels of effects found before, whose parameters are own figures here."""
    groups: tuple[tuple[int, ...], ...] = ()
    """Entries that may be added in one step."""

    def sets(self, most: int) -> list[Explanation]:
        """Return sets of effects, the best first; no effect is among them.

        Source: Hastie, Tibshirani and Friedman 2009, section 3.3.2 (forward selection, here of the
        best few of each size; the best of all is then reduced backwards).

        Args:
            most: Most steps, each of which adds an effect or a group.
        """
        tried: dict[tuple[int, ...], _Candidate] = {(): self._fitted(())}
        none, beam = tried[()].best.evidence, list(tried.values())
        for _ in range(most):
            grown = {
                members: self._fitted(members)
                for base in beam
                for members in self._promising(base)
                if members not in tried
            }
            tried |= grown
            ordered = sorted(grown.values(), key=lambda each: -each.best.evidence)
            if not ordered or ordered[0].best.evidence <= beam[0].best.evidence:
                break
            beam = ordered[:BEAM_WIDTH]
        best = max(tried.values(), key=lambda each: each.best.evidence)
        while best.members:
            fewer = [
                self._fitted(tuple(m for m in best.members if m != gone)) for gone in best.members
            ]
            tried |= {each.members: each for each in fewer}
            shorter = max(fewer, key=lambda each: each.best.evidence)
            if shorter.best.evidence <= best.best.evidence:
                break
            best = shorter
        explained = [
            Explanation(
                effects=each.best.effects,
                gain=each.best.evidence - none,
                own=each.best.own,
                members=each.members,
                level=each.fits.index(each.best),
            )
            for each in tried.values()
        ]
        return sorted(explained, key=lambda each: -each.gain)

    def instead(
        self, label: str, entries: Integers, change: Array
    ) -> tuple[float, list[tuple[Effect, float]]]:
        """Return log odds against an effect found before: of nothing, and of others in its place.

        In nats, of each other effect at its best shape, likeliest first.

        Args:
            label: The effect's.
            entries: Its parameters among the own figures.
            change: What takes them to neutral.
        """
        rank = int(np.sum(np.diag(self.levels[0].gram)[1 + entries] > 0.0))
        held = self._fitted(()).best.evidence - 0.5 * rank * math.log(self.readings)
        levels = tuple(level.fixed(entries, change) for level in self.levels)
        without = replace(self, levels=levels, known=self.known - {label}, groups=())
        none = without._fitted(()).best.evidence
        others = [each for each in without.sets(1) if len(each.effects) == 1]
        return none - held, [(each.effects[0], each.gain + none - held) for each in others]

    def without_fold(self, found: Explanation, fold: int) -> tuple[Array, tuple[Effect, ...]]:
        """Return the change of own figures and the effects, fitted to all folds but one."""
        columns = [self.columns[each] for each in found.members]
        fit = self.levels[found.level].without_fold(fold).fit(columns, self.readings, 0.0)
        return fit.own, fit.effects

    def price(self, members: Collection[int]) -> float:
        """Return the price of the effects found before and some entries, nats."""
        return self.prior.price(self.known | {self.columns[at].effect.label for at in members})

    def _fitted(self, members: tuple[int, ...]) -> _Candidate:
        columns, price = [self.columns[each] for each in members], self.price(members)
        fits = [level.fit(columns, self.readings, price) for level in self.levels]
        return _Candidate(members=members, fits=fits)

    def _promising(self, base: _Candidate) -> list[tuple[int, ...]]:
        """Return a set with what gains most added, each effect at its best shape."""
        taken = {effect.label for effect in base.best.effects}
        place = self._place(base.members)
        steps = [*((at,) for at in range(len(self.columns))), *self.groups]
        price = self.price(base.members)
        best: dict[tuple[str, ...], tuple[float, tuple[int, ...]]] = {}
        for level, fit in zip(self.levels, base.fits, strict=True):
            rest = level.rest(fit.held)
            if len(place):
                rest = _projected(rest, rest[np.ix_(place, place)], rest[place])
            for step in steps:
                added = [at for at in step if self.columns[at].effect.label not in taken]
                if len(added) < len(step) and (len(step) == 1 or not added):
                    continue
                effects = [self.columns[at].effect for at in added]
                columns = self._place(added)
                along, inner = rest[columns, 0], rest[np.ix_(columns, columns)]
                strengths, rank = bounded(inner, along, *_all_bounds(effects))
                members = tuple(sorted({*base.members, *added}))
                gain = strengths @ along - 0.5 * strengths @ inner @ strengths
                gain += fit.evidence - 0.5 * rank * math.log(self.readings)
                gain -= self.price(members) - price
                labels = tuple(effect.label for effect in effects)
                best[labels] = max(best.get(labels, (-math.inf, members)), (float(gain), members))
        ordered = sorted(best.values(), reverse=True)
        return [members for _, members in (ordered[:BRANCHES] if len(place) else ordered)]

    def _place(self, members: Sequence[int]) -> Integers:
        """Return the columns of some entries."""
        slices = [self.columns[each].place for each in members]
        return np.concatenate([np.zeros(0, int), *(np.r_[each] for each in slices)])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Candidate:
    """A set of entries of the dictionary, fitted."""

    members: tuple[int, ...]
    """Their indices, in order."""
    fits: list[_Fit]
    """One for each level."""

    @property
    def best(self) -> _Fit:
        """The fit at the likeliest level."""
        return max(self.fits, key=lambda fit: fit.evidence)


def _projected(gram: Array, inner: Array, across: Array) -> Array:
    """Return a Gram matrix with some columns projected out, those that depend on others once.

    Args:
        gram: The matrix, shape (columns, columns).
        inner: That of the columns to project out, shape (some, some).
        across: Their inner products with all, shape (some, columns).
    """
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    inverse = np.linalg.pinv(inner / np.outer(scale, scale), rcond=RANK_TOLERANCE, hermitian=True)
    across = across / scale[:, None]
    return np.asarray(gram - across.T @ inverse @ across)


def _all_bounds(effects: Sequence[Effect]) -> tuple[Array, Array]:
    """Return the bounds of the columns of some effects."""
    pairs = [(np.zeros(0), np.zeros(0)), *(effect.coefficient_bounds() for effect in effects)]
    low, high = zip(*pairs, strict=True)
    # Equal bounds leave an interval.
    return np.concatenate(low) - 1e-12, np.concatenate(high) + 1e-12
