"""Beam search for sets of effects by the Gram matrix of their columns; nothing is simulated."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from morph.arrays import Array, Integers
from morph.inference.bounded import NEGLIGIBLE, RANK_TOLERANCE, bounded
from morph.inference.level import EffectColumn, LevelFit, WhitenedLevel, all_bounds, projected
from morph.physics.effect import Effect

BEAM_WIDTH, BRANCHES = 6, 12
"""How many sets of one size are grown, and by how many effects each set is, one at a time."""
SINGLES = 40
"""How many single effects are fitted."""


@dataclass(frozen=True, kw_only=True)
class Prior:
    """How probable sets of effects are before any run, as prices: negative logarithms, nats."""

    alone: Mapping[str, float]
    """Price of each effect, by its label."""
    together: tuple[tuple[frozenset[str], float], ...] = ()
    """Labels of effects that come together, as one law at every joint, and the price of them all;
    larger groups first."""

    def price(self, labels: Collection[str]) -> float:
        """Return the price of a set of effects; one that is not listed costs as the dearest."""
        left, price = set(labels), 0.0
        for group, whole in self.together:
            if group <= left and whole < sum(self.alone[label] for label in group):
                left, price = left - group, price + whole
        dearest = max(self.alone.values(), default=0.0)
        return price + sum(self.alone.get(label, dearest) for label in left)


@dataclass(frozen=True, kw_only=True, eq=False)
class Explanation:
    """A set of effects at its likeliest strengths, and own parameters refitted beside it."""

    effects: tuple[Effect, ...]
    """None, one or several, each at the best shape of its grid."""
    gain: float
    """Log evidence less that of no effect, less prices, nats."""
    own: Array
    """Change of each entry of the point about which the runs are linearised, shape (own,)."""
    members: tuple[int, ...]
    """Its entries of the dictionary."""
    level: int
    """Index of the scale of the missing force at which it is likeliest, in `BeamSearch.levels`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BeamSearch:
    """A beam search for sets of effects."""

    columns: tuple[EffectColumn, ...]
    """The dictionary."""
    levels: tuple[WhitenedLevel, ...]
    """One for each scale of the missing force."""
    readings: int
    """How many readings there are."""
    prior: Prior
    """How probable sets are beforehand."""
    found: tuple[Effect, ...] = ()
    """Effects found before, whose parameters are own parameters here."""
    groups: tuple[tuple[int, ...], ...] = ()
    """Entries that may be added in one step."""
    needs: Mapping[int, int] = field(default_factory=dict)
    """Entries that act through another one alone, and which: a current through a drag."""

    def sets(self, most: int) -> list[Explanation]:
        """Return sets of effects, the best first; the empty set is among them.

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
            through = {self.needs.get(at) for at in best.members}
            fewer = [
                self._fitted(tuple(m for m in best.members if m != gone))
                for gone in best.members
                if gone not in through
            ]
            tried |= {each.members: each for each in fewer}
            shorter = max(fewer, key=lambda each: each.best.evidence)
            if shorter.best.evidence <= best.best.evidence:
                break
            best = shorter
        return sorted((each.beside(none) for each in tried.values()), key=lambda each: -each.gain)

    def single(self, result: Explanation) -> bool:
        """Return whether a set is one effect, or a current and the drag through which it acts."""
        through = {self.needs.get(at) for at in result.members}
        return len(set(result.members) - through) == 1

    def together(self) -> list[Explanation]:
        """Return the groups as sets of effects, the best first."""
        none = self._fitted(()).best.evidence
        fitted = (self._fitted(tuple(sorted(group))).beside(none) for group in self.groups)
        return sorted(fitted, key=lambda each: -each.gain)

    def instead(
        self, label: str, entries: Integers, change: Array
    ) -> tuple[float, list[tuple[Effect, float]]]:
        """Return log odds against an effect found before: of nothing, and of others in its place.

        In nats, of each other effect at its best shape, likeliest first.

        Args:
            label: The effect's.
            entries: Its parameters among the own parameters.
            change: What takes them to neutral.
        """
        held = self._fitted(()).best.evidence - 0.5 * len(entries) * math.log(self.readings)
        levels = tuple(level.fixed(entries, change) for level in self.levels)
        rest = tuple(effect for effect in self.found if effect.label != label)
        without = replace(self, levels=levels, found=rest, groups=())
        none = without._fitted(()).best.evidence
        others = [each for each in without.sets(1) if len(each.effects) == 1]
        return none - held, [(each.effects[0], each.gain + none - held) for each in others]

    def without_fold(self, result: Explanation, fold: int) -> tuple[Array, tuple[Effect, ...]]:
        """Return the change of own parameters and the effects, fitted to all folds but one."""
        columns = [self.columns[each] for each in result.members]
        fit = self.levels[result.level].without_fold(fold).fit(columns, self.readings, 0.0)
        return fit.own, fit.effects

    def price(self, members: Collection[int]) -> float:
        """Return the price of the effects found before and some entries, nats."""
        labels = {effect.label for effect in self.found}
        return self.prior.price(labels | {self.columns[at].label for at in members})

    def _fitted(self, members: tuple[int, ...]) -> _Candidate:
        columns, price = [self.columns[each] for each in members], self.price(members)
        fits = [level.fit(columns, self.readings, price) for level in self.levels]
        return _Candidate(members=members, fits=fits)

    def _promising(self, base: _Candidate) -> list[tuple[int, ...]]:
        """Return a set with what gains most added, each effect at its best shape.

        What an addition gains without its bounds is the most that it can gain within them: those
        that cannot be among the best are not fitted.
        """
        there = (*self.found, *base.best.effects)
        taken = {effect.label for effect in there}
        alone = ((at,) for at in range(len(self.columns)) if at not in self.needs)
        steps = [*alone, *self.groups]
        options: list[tuple[int, ...]] = []
        for at, through in self.needs.items():
            if through in base.members:
                steps.append((at,))
            elif not taken & {self.columns[at].label, self.columns[through].label}:
                steps.append((through, at))
        for step in steps:
            added = tuple(at for at in step if self.columns[at].label not in taken)
            others = [self.columns[at].effect for at in added]
            fits = all(one.beside(other) for one in others for other in there)
            if added and fits and (len(step) > 1 or added == step):
                options.append(added)
        prices = np.array([self.price({*base.members, *added}) for added in options])
        prices -= self.price(base.members)
        rests, place = [], self._place(base.members)
        for level, fit in zip(self.levels, base.fits, strict=True):
            rest = level.rest(fit.held)
            if len(place):
                rest = projected(rest, rest[np.ix_(place, place)], rest[place])
            rests.append(rest)
        evidence = np.array([[fit.evidence] for fit in base.fits])
        most = evidence - prices + self._most_gains(rests, options)
        best: dict[tuple[str, ...], tuple[float, tuple[int, ...]]] = {}
        wanted, least = BRANCHES if base.members else SINGLES, -math.inf
        for at in np.argsort(-most.max(axis=0)):
            if most[:, at].max() <= least:
                break
            added = options[at]
            entries = [self.columns[each] for each in added]
            gain = float(np.max(evidence[:, 0] + [self._gain(rest, added) for rest in rests]))
            labels = tuple(entry.label for entry in entries)
            members = tuple(sorted({*base.members, *added}))
            if gain == -math.inf:
                continue
            new = (gain - float(prices[at]), members)
            best[labels] = max(best.get(labels, new), new)
            if len(best) >= wanted:
                least = sorted((gain for gain, _ in best.values()), reverse=True)[wanted - 1]
        return [members for _, members in sorted(best.values(), reverse=True)[:wanted]]

    def _most_gains(self, rests: Sequence[Array], options: Sequence[tuple[int, ...]]) -> Array:
        """Return what additions gain without bounds, for one column exactly: (levels, options)."""
        result, least = np.empty((len(rests), len(options))), 0.5 * math.log(self.readings)
        places = [self._place(added) for added in options]
        sizes = np.array([len(place) for place in places])
        for size in np.unique(sizes):
            same = np.flatnonzero(sizes == size)
            columns = np.stack([places[at] for at in same])
            bounds = [
                all_bounds([self.columns[at] for at in options[each]]) for each in same.tolist()
            ]
            low, high = (np.stack(side) for side in zip(*bounds, strict=True))
            for at, rest in enumerate(rests):
                along = rest[columns, 0]
                inner = rest[columns[:, :, None], columns[:, None, :]]
                if size == 1:
                    square = inner[:, 0]
                    with np.errstate(divide="ignore", invalid="ignore"):
                        best = np.where(square > 0.0, np.clip(along / square, low, high), 0.0)
                    gain = (best * along - 0.5 * best**2 * square)[:, 0]
                else:
                    scale = np.sqrt(np.maximum(inner[:, range(size), range(size)], 0.0))
                    seen = scale > NEGLIGIBLE * scale.max(axis=1, keepdims=True)
                    scale[~seen] = np.inf
                    unit = inner / (scale[:, :, None] * scale[:, None])
                    inverse = np.linalg.pinv(unit, rcond=RANK_TOLERANCE, hermitian=True)
                    along = along / scale
                    gain = 0.5 * np.einsum("si,sij,sj->s", along, inverse, along)
                result[at, same] = gain - least
        return result

    def _gain(self, rest: Array, added: Sequence[int]) -> float:
        """Return what an addition gains, less the price of its columns."""
        columns = self._place(added)
        along, inner = rest[columns, 0], rest[np.ix_(columns, columns)]
        strengths, rank = bounded(inner, along, *all_bounds([self.columns[at] for at in added]))
        if not rank:
            return -math.inf  # It does nothing here.
        gain = strengths @ along - 0.5 * strengths @ inner @ strengths
        return float(gain - 0.5 * rank * math.log(self.readings))

    def _place(self, members: Sequence[int]) -> Integers:
        """Return the columns of some entries."""
        slices = [self.columns[each].place for each in members]
        return np.concatenate([np.zeros(0, int), *(np.r_[each] for each in slices)])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Candidate:
    """A set of entries of the dictionary, fitted."""

    members: tuple[int, ...]
    """Their indices, in order."""
    fits: list[LevelFit]
    """One for each level."""

    @property
    def best(self) -> LevelFit:
        """The fit at the likeliest level."""
        return max(self.fits, key=lambda fit: fit.evidence)

    def beside(self, none: float) -> Explanation:
        """Return the set as an explanation; `none` is the log evidence of no effect."""
        best = self.best
        return Explanation(
            effects=best.effects,
            gain=best.evidence - none,
            own=best.own,
            members=self.members,
            level=self.fits.index(best),
        )
