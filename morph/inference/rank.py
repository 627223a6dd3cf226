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

from morph.arrays import Array
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
"""Most effects that are taken one after another."""
ROUNDS = 2
"""How often own figures are refitted before effects are looked for."""
SEEN = 1e-8
"""Least eigenvalue of an effect's scaled columns that counts as a direction."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Column:
    """Columns of one effect at one shape."""

    effect: Effect
    place: slice
    price: float


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """One effect at its likeliest strength."""

    effect: Effect
    """The effect; shapes of its law as in the best entry of their grid."""
    tried: Effect
    """The entry of the dictionary that it is."""
    gain: float
    """Logarithm of the evidence beyond that of the description's own figures, less its price."""


def ranked(nominal: Hypothesis, episodes: Sequence[Episode]) -> list[list[Ranked]]:
    """Return every effect at every place, the one with the most evidence first.

    While the first explains more than its price it is taken, and the others are ranked again
    beside it: one list for each effect that is taken, and one of what is left.

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
    columns = list(_columns(grids, first=1 + len(trust)))
    levels = [
        _without(believed(level, trust, point), trust)
        for level in _whitened(nominal, point, grids, runs, LEVELS)
    ]
    readings = sum(int(run.about.tangent.valid.sum()) for run in runs)
    found = [_ranked(levels, columns, readings)]
    while found[-1][0].gain > 0.0 and len(found) < MOST:
        taken = next(c for c in columns if c.effect is found[-1][0].tried)
        levels = [_taken(evidence, rest, taken, readings) for evidence, rest in levels]
        columns = [c for c in columns if c.effect.label != taken.effect.label]
        found.append(_ranked(levels, columns, readings))
    return found


def _ranked(
    levels: Sequence[tuple[float, Array]], columns: Sequence[_Column], readings: int
) -> list[Ranked]:
    """Return every effect by its evidence beyond that of what was taken already."""
    none = max(evidence for evidence, _ in levels)
    best: dict[str, Ranked] = {}
    for evidence, rest in levels:
        for column in columns:
            place, effect = column.place, column.effect
            fitted, gain, rank = _fit(effect, rest[place, place], rest[place, 0])
            gain += evidence - none - 0.5 * rank * math.log(readings) - column.price
            if effect.label not in best or gain > best[effect.label].gain:
                best[effect.label] = Ranked(effect=fitted, tried=effect, gain=gain)
    return sorted(best.values(), key=lambda each: -each.gain)


def _taken(evidence: float, rest: Array, column: _Column, readings: int) -> tuple[float, Array]:
    """Return the evidence with one more effect, and the Gram matrix of what it leaves."""
    place = column.place
    inner = rest[place, place]
    _, gain, rank = _fit(column.effect, inner, rest[place, 0])
    size = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    pseudo = np.linalg.pinv(inner / np.outer(size, size), rcond=SEEN) / np.outer(size, size)
    left = rest - rest[:, place] @ pseudo @ rest[place, :]
    return evidence + gain - 0.5 * rank * math.log(readings) - column.price, left


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
    slack = 1e-9
    bounds = (nominal.low - point - slack, nominal.high - point + slack)
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


def _without(level: Whitened, trust: Array) -> tuple[float, Array]:
    """Return the evidence with own figures alone, and the Gram matrix of what they leave."""
    own = slice(1, 1 + len(trust))
    inner = level.gram[own, own]
    rest = level.gram - level.gram[:, own] @ np.linalg.solve(inner, level.gram[own, :])
    return -0.5 * (rest[0, 0] + level.logarithm), rest


def _fit(effect: Effect, inner: Array, along: Array) -> tuple[Effect, float, int]:
    """Return an effect at its best strengths, the log likelihood that it adds, and its rank."""
    size = np.sqrt(np.maximum(np.diag(inner), 0.0))
    seen = size > 1e-6 * size.max(initial=1e-300)
    if not seen.any():
        return effect, 0.0, 1
    scale = size[seen]
    values, vectors = np.linalg.eigh(inner[np.ix_(seen, seen)] / np.outer(scale, scale))
    kept = values > SEEN
    root = np.sqrt(values[kept])[:, None] * vectors[:, kept].T
    goal = (vectors[:, kept].T @ (along[seen] / scale)) / np.sqrt(values[kept])
    low, high = _bounds(effect)
    found = lsq_linear(root, goal, bounds=(low[seen] * scale, high[seen] * scale))
    free = np.zeros(len(along))
    free[seen] = found.x / scale
    fitted = effect.with_strengths(free)
    # Shapes that scale with the strength stay as they were tried.
    strengths = fitted.coefficients
    gain = float(strengths @ along - 0.5 * strengths @ inner @ strengths)
    return fitted, max(0.0, gain), int(kept.sum())


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


def _columns(grids: Sequence[tuple[Effect, ...]], first: int) -> Iterator[_Column]:
    """Give where each effect stands in the Gram matrix, one column for each strength."""
    for grid in grids:
        for effect in grid:
            end = first + len(effect.strengths)
            price = math.log(len(grid) * len(grids))
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
