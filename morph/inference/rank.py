"""Ranking of sets of effects by how well they explain a robot's runs; nothing is simulated.

The description is refitted to the runs and linearised along them. Every effect at every place and
shape gives a column or a few; their Gram matrix in the metric of the readings scores each set
beside the description's own figures. The best sets are refitted, and the search goes on from the
best refit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.inference.columns import Columns
from morph.inference.filter import Whitened, whitened
from morph.inference.observed import Observed
from morph.inference.refit import Refit, offset, prior, refitted
from morph.inference.search import Column, Explanation, Level, Search
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.physics.motion import Motion

LEVELS = (1.0, 0.3, 0.1, 0.03)
"""Scales of the missing force, as shares of the likeliest one before effects are added. A set that
explains more leaves less of it: each is scored at the scale under which it is likeliest."""
FINALISTS = 2
"""How many of the best sets, and of the best single effects, are refitted in each search."""
MOST = 4
"""Most effects that the first search adds; each of the two later ones adds at most one."""
STEPS = 5
"""Most Gauss-Newton steps of a refit, of own figures alone and of a finalist."""
WORSE = 20.0
"""Nats: a refit stops when it predicts this much less evidence than the best so far."""
ODDS = 3.0
"""Prior log odds against one more effect, nats."""
SLACK = 1e-9
"""By how much bounds are widened, so that equal ones leave an interval."""


def ranked(
    nominal: Hypothesis, episodes: Sequence[Episode], known: Sequence[Effect] = ()
) -> list[Explanation]:
    """Return the refitted sets of effects, most evidence first; the empty set is among them.

    A beam search grows sets one effect at a time from the best few of each size, which finds two
    effects of which neither explains much alone.

    Args:
        nominal: The description, with its figures that may be wrong, and no effect.
        episodes: Its runs.
        known: Effects whose fixed parameters are known, such as a paddle's edge. They are looked
            for instead of those at the same places with defaults.
    """
    none = refitted(nominal, nominal.start, episodes, rounds=STEPS)
    tried, best = [Explanation(effects=(), gain=0.0)], none
    prices: dict[str, float] = {}
    for most in (MOST, 1, 1):
        search = _search(best, known)
        prices |= {c.effect.label: c.price for c in search.columns}
        before = best
        for found in _finalists(search.sets(most)):
            start = replace(nominal, effects=(*before.effects, *found.effects))
            point = np.concatenate([before.point + found.own, start.start[len(before.point) :]])
            price = sum(prices[effect.label] for effect in start.effects)
            refit = refitted(
                start,
                point,
                episodes,
                origin=before,
                rounds=STEPS,
                least=_gain(best, prices) + price - WORSE,
            )
            gain = _gain(refit, prices) - none.evidence
            tried.append(Explanation(effects=refit.effects, gain=gain))
            if gain > _gain(best, prices) - none.evidence:
                best = refit
        if best is before:
            break
    return sorted(tried, key=lambda each: -each.gain)


def _gain(refit: Refit, prices: Mapping[str, float]) -> float:
    return refit.evidence - sum(prices[effect.label] for effect in refit.effects)


def _finalists(sets: Sequence[Explanation]) -> list[Explanation]:
    """Return the best sets, the best single effects, and the best set less each of its effects."""
    some = [each for each in sets if each.effects and each.gain > -5.0]
    alone = [each for each in some if len(each.effects) == 1]
    less: list[Explanation] = []
    if some:
        (best, *_), whole = some, some[0].effects
        less = [replace(best, effects=tuple(e for e in whole if e is not gone)) for gone in whole]
    found: dict[tuple[str, ...], Explanation] = {}
    for each in [*some[:FINALISTS], *alone[:FINALISTS], *less]:
        if each.effects:
            found.setdefault(tuple(sorted(effect.label for effect in each.effects)), each)
    return list(found.values())


def _search(base: Refit, known: Sequence[Effect]) -> Search:
    """Return a search for effects to add to a refitted hypothesis."""
    hypothesis, point, runs = base.hypothesis, base.point, base.runs
    taken = {effect.label for effect in base.effects}
    grids = [g for g in dictionary(hypothesis.robot, runs, known) if g[0].label not in taken]
    trust, at = prior(hypothesis), offset(hypothesis, point)
    return Search(
        columns=tuple(_columns(grids)),
        levels=tuple(
            Level(
                gram=believed(level, trust, at).gram,
                logarithm=level.logarithm,
                low=hypothesis.low - point - SLACK,
                high=hypothesis.high - point + SLACK,
            )
            for level in _whitened(hypothesis, point, grids, runs)
        ),
        readings=sum(int(run.about.tangent.valid.sum()) for run in runs),
    )


def dictionary(
    robot: Robot, runs: Sequence[Observed], known: Sequence[Effect]
) -> Iterator[tuple[Effect, ...]]:
    """Yield each effect at each place, as a tuple over the shapes of its grid."""
    longest = max((run.motion for run in runs), key=lambda motion: len(motion.time))
    measured, told = set(longest.channels), {effect.label: effect for effect in known}
    for kind in EFFECTS:
        for place in kind.places(robot) if kind.strengths else ():
            if kind.kind != "sensor" or place in measured:
                with suppress(EffectError):  # It needs what the description does not tell.
                    effect = kind.at(place)
                    effect = told.get(effect.label, effect)
                    effect.regressor(longest)
                    yield _shapes(effect, longest)


def _shapes(effect: Effect, motion: Motion) -> tuple[Effect, ...]:
    """Return the effect at a few values of the parameters in which it is not linear."""
    if type(effect).command is Effect.command:
        return effect.shapes(motion)
    # A filter of a command is linear in its time constant only while that is short.
    return tuple(
        replace(effect, **{known.name: value})  # type: ignore[type-var]
        for known in effect.parameters()
        for value in known.scan
    )


def believed(level: Whitened, trust: Array, point: Array) -> Whitened:
    """Return a Gram matrix with the Gaussian prior of own figures as further readings.

    Args:
        level: Of [errors, own figures, effects].
        trust: One over the prior variance of each own figure, shape (own,).
        point: Their values less the likeliest ones beforehand, same shape.
    """
    gram, own = level.gram.copy(), slice(1, 1 + len(trust))
    gram[own, own] += np.diag(trust)
    gram[0, own] -= trust * point
    gram[own, 0] -= trust * point
    gram[0, 0] += float(point @ (trust * point))
    return replace(level, gram=gram)


def _columns(grids: Sequence[tuple[Effect, ...]]) -> Iterator[Column]:
    """Yield the columns of each effect at each shape: one for each strength, after the errors."""
    first = 1
    for grid in grids:
        for effect in grid:
            end = first + len(effect.strengths)
            price = ODDS + math.log(len(grid) * len(grids))
            yield Column(effect=effect, place=slice(first, end), price=price)
            first = end


def _whitened(
    hypothesis: Hypothesis,
    point: Array,
    grids: Sequence[tuple[Effect, ...]],
    runs: Sequence[Observed],
) -> list[Whitened]:
    """Return the Gram matrix of [errors, entries of the point, effects] over all runs, by level."""
    own = Columns.of(hypothesis, point)
    grams: list[list[Whitened]] = [[] for _ in LEVELS]
    for seen in runs:
        about, motion = seen.about, seen.motion
        moved, shown = own.along(seen)
        forces = np.concatenate([_pushed(grid, motion) for grid in grids], axis=2)
        moved = np.concatenate(
            [moved, about.tangent.jacobian[:, :, 2 * moved.shape[1] :] @ forces], axis=2
        )
        changes = [effect.reading_regressor(motion) for grid in grids for effect in grid]
        readings = np.concatenate([shown, *changes], axis=2)
        for level, found in zip(LEVELS, grams, strict=True):
            leaving = replace(about.leaving(level), noise=seen.run.noise)
            found.append(whitened(about.tangent, leaving, readings, moved))
    return [sum(found[1:], start=found[0]) for found in grams]


def _pushed(shapes: tuple[Effect, ...], motion: Motion) -> Array:
    """Return forces of one effect at several shapes, (samples, dofs, columns); sensors: zero."""
    forces = shapes[0].regressors(shapes, motion)
    return np.zeros_like(forces) if shapes[0].kind == "sensor" else forces
