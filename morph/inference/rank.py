"""Which effects explain a robot's runs, by linear algebra, before any of them is simulated.

Each run is smoothed by the description, its own figures refitted, and linearised once. Every effect
at every place is a column, or a few; one Gram matrix in the metric of the readings tells what each
explains beside the description's own figures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from morph.arrays import Array, Mask
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.inference.figures import force_between
from morph.inference.filter import Whitened, whitened
from morph.inference.observed import Observed, observed
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.physics.motion import Motion

LEVELS = (1.0, 0.3, 0.1, 0.03)
"""Scales of the missing force, as shares of what is likeliest without any effect. An effect that
explains it needs less: each is judged at the scale under which it is likeliest."""
NUDGE = 1e-3
"""Step of the difference by an own figure's logarithm."""
MOST = 4
"""Most effects of a set."""
WIDTH, SHORT = 6, 12
"""How many sets of one size are grown, and with how many effects each."""
ROUNDS = 2
"""How often own figures are refitted before effects are looked for."""
ODDS = 3.0
"""Logarithm of the odds, before any data, against one more effect."""
SLACK = 1e-9
"""Least width of a bound."""
SEEN = 1e-8
"""Least eigenvalue of an effect's scaled columns that counts as a direction."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Column:
    """Columns of one effect at one shape."""

    effect: Effect
    place: slice
    price: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fit:
    """Own figures and effects at their likeliest under one scale of the missing force."""

    effects: tuple[Effect, ...]
    evidence: float
    held: Mask
    """Which own figures are at a bound."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Level:
    """Errors, own figures and effects, whitened under one scale of the missing force."""

    gram: Array
    """Their Gram matrix, with the prior of the own figures."""
    logarithm: float
    """Logarithm of the determinant of the readings' covariance."""
    low: Array
    """By how much each own figure may fall."""
    high: Array
    """By how much each may rise."""

    def rest(self, held: Mask) -> Array:
        """Return the Gram matrix of errors and effects beside own figures that are free."""
        count = len(self.low)
        own, kept = 1 + np.flatnonzero(~held), np.r_[0, 1 + count : len(self.gram)]
        across = self.gram[np.ix_(own, kept)]
        inner = self.gram[np.ix_(own, own)]
        left = self.gram[np.ix_(kept, kept)] - across.T @ np.linalg.solve(inner, across)
        return np.asarray(left)

    def fit(self, columns: Sequence[_Column], readings: int) -> _Fit:
        """Return own figures and effects at their likeliest, all within their bounds."""
        count = len(self.low)
        effects = tuple(column.effect for column in columns)
        places = [np.r_[column.place] + count for column in columns]
        low, high = _ends(effects)
        low, high = np.concatenate([self.low, low]), np.concatenate([self.high, high])
        chosen = np.concatenate([np.arange(1, 1 + count), *places]).astype(int)
        inner, along = self.gram[np.ix_(chosen, chosen)], self.gram[chosen, 0]
        best, rank = _bounded(inner, along, low, high)
        ends = np.cumsum([count, *(len(place) for place in places)])[:-1]
        own, *parts = np.split(best, ends) if columns else [best]
        # Shapes that scale with the strength stay as they were tried.
        effects = tuple(e.with_strengths(part) for e, part in zip(effects, parts, strict=True))
        strengths = np.concatenate([best[:0], *(effect.coefficients for effect in effects)])
        if not np.allclose(strengths, best[count:], rtol=1e-6):
            left = along[:count] - inner[:count, count:] @ strengths
            own, _ = _bounded(inner[:count, :count], left, self.low, self.high)
        whole = np.concatenate([own, strengths])
        square = self.gram[0, 0] - 2.0 * along @ whole + whole @ inner @ whole
        price = 0.5 * (rank - count) * math.log(readings) + sum(c.price for c in columns)
        slack = 1e-3 * (self.high - self.low)
        return _Fit(
            effects=effects,
            evidence=-0.5 * float(square + self.logarithm) - price,
            held=(own < self.low + slack) | (own > self.high - slack),
        )


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """Effects at their likeliest strengths, with the description's own figures refitted."""

    effects: tuple[Effect, ...]
    """None, one or several; shapes of their laws as in the best entries of their grids."""
    gain: float
    """Logarithm of the evidence beyond that of no effect, less the price of what was tried."""


def ranked(nominal: Hypothesis, episodes: Sequence[Episode]) -> list[Explanation]:
    """Return sets of effects, the one with the most evidence first; no effect is among them.

    Sets are grown one effect at a time from the best few of each size (a beam search), so that
    two effects are found together of which neither explains much alone.

    Args:
        nominal: The description, with the figures of it that may be wrong.
        episodes: Its runs.
    """
    trust = np.array([1.0 / knob.fraction**2 for knob in nominal.knobs])
    point = nominal.start
    runs = _seen(nominal, point, episodes)
    for _ in range(ROUNDS if len(trust) else 0):
        point = _refitted(nominal, point, trust, runs)
        runs = _seen(nominal, point, episodes, runs)
    grids = list(_dictionary(nominal.robot, runs))
    search = _Search(
        columns=tuple(_columns(grids)),
        levels=tuple(
            _Level(
                gram=believed(level, trust, point).gram,
                logarithm=level.logarithm,
                low=nominal.low - point - SLACK,
                high=nominal.high - point + SLACK,
            )
            for level in _whitened(nominal, point, grids, runs, LEVELS)
        ),
        readings=sum(int(run.about.tangent.valid.sum()) for run in runs),
    )
    return search.sets()


@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """A search for sets of effects by the Gram matrix of their columns."""

    columns: tuple[_Column, ...]
    levels: tuple[_Level, ...]
    readings: int

    def sets(self) -> list[Explanation]:
        """Return what was tried, the best first."""
        tried = [_Tried(members=(), fits=[level.fit((), self.readings) for level in self.levels])]
        none, beam = tried[0].best.evidence, list(tried)
        while len(beam[0].members) < MOST:
            grown: dict[tuple[int, ...], _Tried] = {}
            for base in beam:
                for at in self._promising(base):
                    members = tuple(sorted((*base.members, at)))
                    if members not in grown:
                        columns = [self.columns[each] for each in members]
                        fits = [level.fit(columns, self.readings) for level in self.levels]
                        grown[members] = _Tried(members=members, fits=fits)
            if not grown:
                break
            ordered = sorted(grown.values(), key=lambda each: -each.best.evidence)
            tried += ordered
            if ordered[0].best.evidence <= beam[0].best.evidence:
                break
            beam = ordered[:WIDTH]
        explained = [
            Explanation(effects=each.best.effects, gain=each.best.evidence - none) for each in tried
        ]
        return sorted(explained, key=lambda each: -each.gain)

    def _promising(self, base: _Tried) -> list[int]:
        """Return the entries that explain most beside some, each effect at its best shape."""
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
                rest = rest - across.T @ np.linalg.pinv(inner, rcond=SEEN) @ across
            for at, column in enumerate(self.columns):
                label, along = column.effect.label, rest[column.place, 0]
                if label in taken:
                    continue
                inner = rest[column.place, column.place]
                strengths, rank = _bounded(inner, along, *_ends([column.effect]))
                gain = strengths @ along - 0.5 * strengths @ inner @ strengths
                gain += fit.evidence - 0.5 * rank * math.log(self.readings) - column.price
                best[label] = max(best.get(label, (-math.inf, at)), (float(gain), at))
        ordered = sorted(best.values(), reverse=True)
        return [at for _, at in (ordered[:SHORT] if len(place) else ordered)]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Tried:
    """A set of entries of the dictionary."""

    members: tuple[int, ...]
    fits: list[_Fit]
    """One a level."""

    @property
    def best(self) -> _Fit:
        """That under which the set is likeliest."""
        return max(self.fits, key=lambda fit: fit.evidence)


def _dictionary(robot: Robot, runs: Sequence[Observed]) -> Iterator[tuple[Effect, ...]]:
    """Give every effect at every place, with each shape of its grid."""
    longest = max((run.motion for run in runs), key=lambda motion: len(motion.time))
    measured = set(longest.channels)
    for kind in EFFECTS:
        for place in kind.places(robot) if kind.strengths else ():
            if kind.kind != "sensor" or place in measured:
                with suppress(EffectError):  # It needs what the description does not tell.
                    kind.at(place).regressor(longest)
                    yield _shapes(kind.at(place), longest)


def _shapes(effect: Effect, motion: Motion) -> tuple[Effect, ...]:
    """Return the effect at a few values of what it is not linear in."""
    if type(effect).command is Effect.command:
        return effect.shapes(motion)
    # What filters a command is linear in its time only while that is short.
    return tuple(
        replace(effect, **{known.name: value})  # type: ignore[type-var]
        for known in effect.parameters()
        for value in known.scan
    )


def _seen(
    nominal: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    before: Sequence[Observed] | None = None,
) -> list[Observed]:
    """Return runs as the description with these own figures explains them."""
    model = nominal.at(point).model
    return [
        observed(model, nominal.robot, each, before=before[at] if before else None)
        for at, each in enumerate(episodes)
    ]


def _refitted(nominal: Hypothesis, point: Array, trust: Array, runs: Sequence[Observed]) -> Array:
    """Return the likeliest own figures to first order about a point."""
    (likeliest,) = _whitened(nominal, point, (), runs, LEVELS[:1])
    gram = believed(likeliest, trust, point).gram
    root = np.linalg.cholesky(gram[1:, 1:])
    goal = np.linalg.solve(root, gram[1:, 0])
    bounds = (nominal.low - point - SLACK, nominal.high - point + SLACK)
    step = lsq_linear(root.T, goal, bounds=bounds).x
    return np.asarray(np.clip(point + step, nominal.low, nominal.high))


def believed(level: Whitened, trust: Array, point: Array) -> Whitened:
    """Return a Gram matrix with the prior of the own figures as further readings."""
    gram, own = level.gram.copy(), slice(1, 1 + len(trust))
    gram[own, own] += np.diag(trust)
    gram[0, own] -= trust * point
    gram[own, 0] -= trust * point
    gram[0, 0] += float(point @ (trust * point))
    return replace(level, gram=gram)


def _bounded(inner: Array, along: Array, low: Array, high: Array) -> tuple[Array, int]:
    """Return the least squares within bounds, by their Gram matrix, and its rank."""
    size = np.sqrt(np.maximum(np.diag(inner), 0.0))
    seen = size > 1e-6 * size.max(initial=1e-300)
    found = np.clip(np.zeros_like(along), low, high)
    if not seen.any():
        return found, 1
    scale = size[seen]
    values, vectors = np.linalg.eigh(inner[np.ix_(seen, seen)] / np.outer(scale, scale))
    kept = values > SEEN
    root = np.sqrt(values[kept])[:, None] * vectors[:, kept].T
    goal = (vectors[:, kept].T @ (along[seen] / scale)) / np.sqrt(values[kept])
    least, most = low[seen] * scale, high[seen] * scale
    best = root.T @ (goal / values[kept])
    if np.any((best < least) | (best > most)):
        best = lsq_linear(root, goal, bounds=(least, most), method="bvls").x
    found[seen] = best / scale
    return found, int(kept.sum())


def _ends(effects: Sequence[Effect]) -> tuple[Array, Array]:
    """Return the bounds of the columns of some effects."""
    pairs = [(np.zeros(0), np.zeros(0)), *(_bounds(effect) for effect in effects)]
    low, high = zip(*pairs, strict=True)
    return np.concatenate(low), np.concatenate(high)


def _bounds(effect: Effect) -> tuple[Array, Array]:
    """Return the least and greatest coefficients where they are strengths less neutral ones."""
    size = len(effect.strengths)
    if type(effect).coefficients is not Effect.coefficients:
        return np.full(size, -np.inf), np.full(size, np.inf)
    known = {p.name: p for p in effect.parameters()}
    pairs = [(known[name], known[name].neutral or 0.0) for name in effect.strengths]
    low = np.array([p.low - neutral for p, neutral in pairs])
    high = np.array([p.high - neutral for p, neutral in pairs])
    return low - 1e-12, high + 1e-12


def _columns(grids: Sequence[tuple[Effect, ...]]) -> Iterator[_Column]:
    """Give where each effect stands behind the errors, one column for each strength."""
    first = 1
    for grid in grids:
        for effect in grid:
            end = first + len(effect.strengths)
            price = ODDS + math.log(len(grid) * len(grids))
            yield _Column(effect=effect, place=slice(first, end), price=price)
            first = end


def _whitened(
    nominal: Hypothesis,
    point: Array,
    grids: Sequence[tuple[Effect, ...]],
    runs: Sequence[Observed],
    levels: Sequence[float],
) -> list[Whitened]:
    """Return Gram matrices of all runs, one a level: their errors, own figures, effects."""
    model = nominal.at(point).model
    turned = [nominal.at(point + NUDGE * axis).model for axis in np.eye(len(point))]
    grams: list[list[Whitened]] = [[] for _ in levels]
    for seen in runs:
        about, motion = seen.about, seen.motion
        samples, dofs = about.position.shape
        columns = [force_between(model, each, motion)[:, :, None] / NUDGE for each in turned]
        shown = [about.error[:, :, None], np.zeros((*about.error.shape, len(turned)))]
        for grid in grids:
            columns.append(grid[0].regressors(grid, motion))
            shown += [effect.reading_regressor(motion) for effect in grid]
        forces = np.concatenate([np.zeros((samples, dofs, 0)), *columns], axis=2)
        mobility = about.tangent.jacobian[:, :, 2 * dofs :]
        moved = np.concatenate([-about.acceleration[:, :, None], mobility @ forces], axis=2)
        readings = np.concatenate(shown, axis=2)
        for level, found in zip(levels, grams, strict=True):
            leaving = replace(about.leaving(level), noise=seen.run.noise)
            found.append(whitened(about.tangent, leaving, readings, moved))
    return [sum(found[1:], start=found[0]) for found in grams]
