"""Beam search for sets of effects by the Gram matrix of their columns; nothing is simulated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from morph.arrays import Array, Mask
from morph.inference.bounded import RANK_TOLERANCE, bounded
from morph.physics.effect import Effect

BEAM_WIDTH, BRANCHES = 6, 12
"""How many sets of one size are grown, and by how many effects each set is, one at a time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """Columns of one effect at one shape, an entry of the dictionary."""

    effect: Effect
    """The effect at that shape."""
    place: slice
    """Its columns, one a strength, of a Gram matrix of [errors, effects] without own figures."""
    price: float
    """Negative log prior: of the effect, its place and its shape, nats."""


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
        left = self.gram[np.ix_(kept, kept)] - across.T @ np.linalg.solve(inner, across)
        return np.asarray(left)

    def fit(self, columns: Sequence[Column], readings: int) -> _Fit:
        """Return own figures and effects at their likeliest, all within their bounds.

        Source: Schwarz 1978, Annals of Statistics 6(2), 461-464 (the price of a column).

        Args:
            columns: The effects.
            readings: How many readings there are.
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
        price = 0.5 * (rank - count) * math.log(readings) + sum(c.price for c in columns)
        slack = 1e-3 * (self.high - self.low)
        return _Fit(
            effects=effects,
            evidence=-0.5 * float(square + self.logarithm) - price,
            own=own,
            held=(own < self.low + slack) | (own > self.high - slack),
        )


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """A set of effects at its likeliest strengths, and own figures refitted beside it."""

    effects: tuple[Effect, ...]
    """None, one or several, each at the best shape of its grid."""
    gain: float
    """Log evidence less that of no effect, less prices, nats."""
    own: Array = field(default_factory=lambda: np.zeros(0), repr=False, compare=False)
    """Change of each entry of the point about which the runs are linearised, shape (own,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Search:
    """A beam search for sets of effects."""

    columns: tuple[Column, ...]
    """The dictionary."""
    levels: tuple[Level, ...]
    """One for each scale of the missing force."""
    readings: int
    """How many readings there are."""

    def sets(self, most: int) -> list[Explanation]:
        """Return sets of at most `most` effects, the best first; no effect is among them."""
        tried = [
            _Candidate(members=(), fits=[level.fit((), self.readings) for level in self.levels])
        ]
        none, beam = tried[0].best.evidence, list(tried)
        while len(beam[0].members) < most:
            grown: dict[tuple[int, ...], _Candidate] = {}
            for base in beam:
                for at in self._promising(base):
                    members = tuple(sorted((*base.members, at)))
                    if members not in grown:
                        columns = [self.columns[each] for each in members]
                        fits = [level.fit(columns, self.readings) for level in self.levels]
                        grown[members] = _Candidate(members=members, fits=fits)
            if not grown:
                break
            ordered = sorted(grown.values(), key=lambda each: -each.best.evidence)
            tried += ordered
            if ordered[0].best.evidence <= beam[0].best.evidence:
                break
            beam = ordered[:BEAM_WIDTH]
        explained = [
            Explanation(
                effects=each.best.effects, gain=each.best.evidence - none, own=each.best.own
            )
            for each in tried
        ]
        return sorted(explained, key=lambda each: -each.gain)

    def _promising(self, base: _Candidate) -> list[int]:
        """Return the entries that gain most beside a set, each effect at its best shape."""
        taken = {effect.label for effect in base.best.effects}
        place = np.concatenate(
            [np.zeros(0, int), *(np.r_[self.columns[m].place] for m in base.members)]
        )
        best: dict[str, tuple[float, int]] = {}
        for level, fit in zip(self.levels, base.fits, strict=True):
            rest = level.rest(fit.held)
            if len(place):
                scale = np.sqrt(np.maximum(np.diag(rest)[place], 1e-300))
                inner = rest[np.ix_(place, place)] / np.outer(scale, scale)
                across = rest[place] / scale[:, None]
                rest = rest - across.T @ np.linalg.pinv(inner, rcond=RANK_TOLERANCE) @ across
            for at, column in enumerate(self.columns):
                label, along = column.effect.label, rest[column.place, 0]
                if label in taken:
                    continue
                inner = rest[column.place, column.place]
                strengths, rank = bounded(inner, along, *_all_bounds([column.effect]))
                gain = strengths @ along - 0.5 * strengths @ inner @ strengths
                gain += fit.evidence - 0.5 * rank * math.log(self.readings) - column.price
                best[label] = max(best.get(label, (-math.inf, at)), (float(gain), at))
        ordered = sorted(best.values(), reverse=True)
        return [at for _, at in (ordered[:BRANCHES] if len(place) else ordered)]


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


def _all_bounds(effects: Sequence[Effect]) -> tuple[Array, Array]:
    """Return the bounds of the columns of some effects."""
    pairs = [(np.zeros(0), np.zeros(0)), *(_bounds(effect) for effect in effects)]
    low, high = zip(*pairs, strict=True)
    return np.concatenate(low), np.concatenate(high)


def _bounds(effect: Effect) -> tuple[Array, Array]:
    """Return the bounds of an effect's coefficients, strengths less neutral ones.

    None where an effect defines its coefficients otherwise.
    """
    size = len(effect.strengths)
    if type(effect).coefficients is not Effect.coefficients:
        return np.full(size, -np.inf), np.full(size, np.inf)
    known = {p.name: p for p in effect.parameters()}
    pairs = [(known[name], known[name].neutral or 0.0) for name in effect.strengths]
    low = np.array([p.low - neutral for p, neutral in pairs])
    high = np.array([p.high - neutral for p, neutral in pairs])
    return low - 1e-12, high + 1e-12
