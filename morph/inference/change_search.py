"""The likeliest law that acts otherwise from one time on, by inner products of its columns."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.inference.bounded import RANK_TOLERANCE, bounded
from morph.inference.design_matrix import believed
from morph.inference.level import EffectColumn
from morph.inference.quadratic import information, offset
from morph.inference.refit import Refit, readings
from morph.inference.search import Prior
from morph.physics.effect import Effect

TRIED = 5
"""Likeliest times of a law at which its strengths are fitted within their bounds."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LikeliestChange:
    """A law that acts otherwise from one time on, in all later runs too."""

    before: Effect
    """The law before, without strength where it did not act."""
    after: Effect
    """The law from then on."""
    run: int
    """Index of the run in which it changes."""
    time: float
    """When, s from the start of that run; 0 where it changed before that."""
    gain: float
    """Log evidence for the change, less its price, nats."""
    lasts: bool = True
    """Whether it shows also away from that time; a push does not."""

    @property
    def label(self) -> str:
        """That of the law."""
        return self.after.label


@dataclass(frozen=True, kw_only=True, eq=False)
class ChangingLaw:
    """A law that may change."""

    label: str
    place: Integers
    """Its columns of [errors, entries, dictionary]."""
    low: Array
    """Least change of each of its strengths, or entries, shape (columns,)."""
    high: Array
    """The greatest."""
    column: EffectColumn | None
    """Of the dictionary; None of a law that was found."""

    @property
    def sides(self) -> tuple[bool, ...]:
        """Whether it acts until a time, or from then on; one that was found does both.

        What happens in one run alone does not change.
        """
        return (False, True) if self.column and not self.passing else (False,)

    @property
    def passing(self) -> bool:
        """Whether it happens in one run alone."""
        return self.column is not None and self.column.effect.passing


def changing_laws(base: Refit, columns: Sequence[EffectColumn]) -> Iterator[ChangingLaw]:
    """Yield the laws that were found and those of the dictionary at each of their shapes."""
    hypothesis, end = base.hypothesis, len(base.hypothesis.knobs)
    for effect in base.effects:
        entries = np.arange(end, end + len(effect.free()))
        end += len(entries)
        if not effect.passing:
            low, high = hypothesis.low[entries], hypothesis.high[entries]
            yield ChangingLaw(
                label=effect.label, place=1 + entries, low=low - high, high=high - low, column=None
            )
    for column in columns:
        low, high = column.bounds
        place = np.arange(column.place.start, column.place.stop) + len(base.point)
        yield ChangingLaw(label=column.label, place=place, low=low, high=high, column=column)


@dataclass(frozen=True, kw_only=True, eq=False)
class Level:
    """Inner products under one scale of the missing force."""

    total: Array
    """Gram matrix of [errors, entries] over all runs, shape (1 + entries, 1 + entries)."""
    logarithm: float
    """Of the determinant of the readings' covariance."""
    acts: Sequence[Sequence[Array]]
    """For each law, where it acts from each time on and, of the dictionary, until then, products of
    its columns with [errors, entries, these]; shape (times, columns, 1 + entries + columns)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChangeSearch:
    """Times at which laws may change, and what would come of it."""

    base: Refit
    """The description with the laws that were found, refitted."""
    prior: Prior
    """Prices of laws."""
    laws: Sequence[ChangingLaw]
    levels: Sequence[Level]
    starts: Sequence[tuple[int, float]]
    """Run and time, s."""
    allowed: Mask
    """Which of these are tried."""

    def likeliest(self) -> LikeliestChange | None:
        """Return the likeliest change, None where no time is allowed."""
        none, best = max(map(self._unchanged, self.levels)), None
        for level, (at, law) in itertools.product(self.levels, enumerate(self.laws)):
            for until, acts in zip(law.sides, level.acts[at], strict=True):
                least = -math.inf if best is None else best.gain
                result = self._of_law(level, law, acts, none, least)
                if result is None:
                    continue
                time, change, gain = result
                before, after = self._sides(law, change, until=until)
                run, begins = self.starts[time]
                # A limit that a fit puts out of reach does nothing.
                if before != after:
                    best = LikeliestChange(
                        before=before, after=after, run=run, time=begins, gain=gain
                    )
        return best

    def _of_law(
        self, level: Level, law: ChangingLaw, acts: Array, none: float, least: float
    ) -> tuple[int, Array, float] | None:
        """Return a law's likeliest time, all changes of entries and its gain, if above `least`."""
        total, best = self._believed(level), None
        size = 0.5 * len(law.place) * math.log(readings(self.base.runs))
        price = none + math.log(self.allowed.sum() + 1.0) + size
        price += self.prior.price([law.label]) if law.column else 0.0
        start, bare = self._unchanged(level), 0.5 * (float(total[0, 0]) + level.logarithm)
        gains = np.where(self.allowed, start + _gains(total, acts) - price, -np.inf)
        for time in np.argsort(-gains)[:TRIED].tolist():
            if gains[time] <= least:
                break
            whole = np.block([[total, acts[time][:, : len(total)].T], [acts[time]]])
            low, high = self._bounds()
            change, gained = _solved(whole, np.append(low, law.low), np.append(high, law.high))
            if gained - bare - price > least:
                least = gained - bare - price
                best = time, change, least
        return best

    def _believed(self, level: Level) -> Array:
        """Return the Gram matrix of [errors, entries] with the prior of own parameters."""
        hypothesis = self.base.hypothesis
        return believed(level.total, information(hypothesis), offset(hypothesis, self.base.point))

    def _unchanged(self, level: Level) -> float:
        """Return the log evidence of no change."""
        total = self._believed(level)
        _, gained = _solved(total, *self._bounds())
        return gained - 0.5 * (float(total[0, 0]) + level.logarithm)

    def _bounds(self) -> tuple[Array, Array]:
        """Return the least and the greatest change of each entry."""
        hypothesis, point = self.base.hypothesis, self.base.point
        return hypothesis.low - point - 1e-9, hypothesis.high - point + 1e-9

    def _sides(self, law: ChangingLaw, change: Array, *, until: bool) -> tuple[Effect, Effect]:
        """Return a law before and after its change."""
        entries, strengths = np.split(change, [len(self.base.point)])
        if law.column is not None:
            there = law.column.effect.with_strengths(strengths)
            idle = law.column.effect.neutral()
            return (there, idle) if until else (idle, there)
        hypothesis, point = self.base.hypothesis, self.base.point + entries
        later = point.copy()
        later[law.place - 1] += strengths
        at = [effect.label for effect in self.base.effects].index(law.label)
        ends = [np.clip(end, hypothesis.low, hypothesis.high) for end in (point, later)]
        first, second = (hypothesis.effects_at(end)[at] for end in ends)
        return first, second


def _solved(gram: Array, low: Array, high: Array) -> tuple[Array, float]:
    """Return what explains errors best within bounds, and the nats that it gains.

    Args:
        gram: Of [errors, columns].
        low: The least of each column.
        high: The greatest.
    """
    inner, along = gram[1:, 1:], gram[1:, 0]
    best, _ = bounded(inner, along, low, high)
    return best, float(along @ best - 0.5 * best @ inner @ best)


def _gains(total: Array, acts: Array) -> Array:
    """Return what a law gains beside the entries, without bounds, nats, shape (times,).

    Args:
        total: Gram matrix of [errors, entries].
        acts: Products of the law's columns with [errors, entries, these]; shape (times, columns,
            1 + entries + columns).
    """
    size = len(total)
    scale = np.sqrt(np.maximum(np.diag(total)[1:], 1e-300))
    unit = total[1:, 1:] / np.outer(scale, scale)
    inverse = np.linalg.pinv(unit, rcond=RANK_TOLERANCE, hermitian=True)
    across = acts[:, :, 1:size] / scale
    fitted = across @ inverse
    along = acts[:, :, 0] - fitted @ (total[1:, 0] / scale)
    inner = acts[:, :, size:] - fitted @ np.swapaxes(across, 1, 2)
    width = np.sqrt(np.maximum(np.diagonal(inner, axis1=1, axis2=2), 1e-300))
    unit = inner / (width[:, :, None] * width[:, None, :])
    along = along / width
    solved = np.linalg.pinv(unit, rcond=RANK_TOLERANCE, hermitian=True) @ along[:, :, None]
    gains: Array = 0.5 * (along * solved[:, :, 0]).sum(axis=1)
    return gains
