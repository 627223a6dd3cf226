"""Ranking of sets of effects by how well they explain a robot's runs.

The description is refitted to the runs and linearised along them. Every effect at every place and
shape gives columns; their Gram matrix in the metric of the readings scores each set beside the
description's own parameters. The best are refitted, and the search goes on from the best refit.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.body.robot import Robot
from morph.inference.by_rollouts import (
    LATER,
    beside,
    on_floor,
    richer,
    to_rollouts,
    with_sensors,
    without_figures,
)
from morph.inference.contact import at_stops, touches
from morph.inference.effect_selection import EffectSelection
from morph.inference.explained import at_noise
from morph.inference.finalist import Finalist, gains, labels, simplified, under
from morph.inference.observed import Observed, missing
from morph.inference.search import BeamSearch, Prior
from morph.inference.validate import FAR, FARTHEST, Validation
from morph.model.deadline import NEVER, Deadline
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect
from morph.physics.kinds import JointEffect

Progress = Callable[[str, float], None]
"""Told what is being done and the share of the work that is behind, 0 to 1."""
MOST_FIRST = 4
"""Most effects, or laws at every joint, that the first search adds."""
NEAR = 0.3
"""The same of a set found by output error, below which the whitened likelihood refits it, to see
whether readings are then explained to their noise."""
MOST_ROUNDS, FAR_ROUNDS = 3, 3
"""Most of these searches after the first, and most by output error, each of which takes long."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking:
    """Sets of effects that were refitted."""

    best: Finalist
    """The one that explains the runs best and of which every effect is needed."""
    tried: tuple[Finalist, ...]
    """Those compared under one criterion, the likeliest first; the empty set is among them."""
    validation: Validation
    """The stretches on which they were compared."""
    search: BeamSearch
    """All effects that might stand beside the best, or in the place of one of its own."""
    stopped: bool
    """Whether there was no time to try all."""

    @property
    def none(self) -> Finalist:
        """The description with its own parameters refitted."""
        return next(each for each in self.tried if not each.effects)


def ranked(
    nominal: Hypothesis,
    episodes: Sequence[Episode],
    known: Sequence[Effect] = (),
    *,
    start: Finalist | None = None,
    coarse: Callable[[Sequence[Observed]], bool] = lambda runs: False,
    progress: Progress = lambda what, share: None,
    deadline: Deadline = NEVER,
) -> Ranking:
    """Return the sets of effects that explain runs best.

    Each round proposes sets to add by their evidence in Gram space, simulates the best of them
    with figures fitted to other folds, refits the best of those, and ends where no addition is
    sure. Evidence alone would trust the model of the missing force, which real drives do not obey;
    errors of rollouts alone tell less about small effects.

    Args:
        nominal: The description, with its figures that may be wrong, and no effect.
        episodes: Its runs.
        known: Effects whose fixed parameters are known: looked for instead of those with defaults.
        start: The best set of another step of the simulation, from which the search goes on.
        coarse: Whether what remains of smoothed runs may be the step's own error. Then the ranking
            ends with its first search, as another in a shorter step is to follow.
        progress: Told what is being done, and the share of the work that is behind.
        deadline: About that of the answer: less what a last search and held-out scores take, no
            step of a refit begins after it.
    """
    touching, stopped = (acts(nominal.robot, episodes) for acts in (touches, at_stops))
    validation = Validation.of(episodes, touching=touching, stopped=stopped)
    # What nothing drives only the floor accelerates, and evidence says nothing of that.
    tossed = touching and not nominal.robot.actuators
    task = EffectSelection(
        nominal=nominal,
        episodes=episodes,
        known=known,
        validation=validation,
        by_rollouts=tossed,
        prior=Prior(alone={}),
        deadline=deadline,
    )
    unbounded = replace(deadline, time=math.inf)
    own = replace(task, deadline=unbounded).refitted(nominal, nominal.start)
    measured = _told(nominal.robot) and not validation.constrained
    most = 0.0 if tossed else FAR if measured else FARTHEST
    far = missing(own.refit.runs) >= most
    begun = None if far and (tossed or start is None) else _begun(task, own, start)
    if far and begun and begun.best.effects:
        # What was found in another step explains the runs well enough to go on by evidence.
        far = missing(begun.best.refit.runs) >= NEAR
    result = _searched(begun if begun and not far else _by_rollouts(task, own), progress)
    if not far and coarse(result.best.refit.runs):
        return _ranking(result, result.none, result.best)
    if not far:
        own = functools.reduce(under, result.tried, own)
        result = replace(result, none=own)
        if not result.tried and not at_noise(own.refit.runs) and not result.task.late():
            # The model of the missing force is wrong: the search goes on by errors of rollouts.
            result = _searched(_by_rollouts(replace(result.task, deadline=deadline), own), progress)
    free = result.task.by_rollouts and not tossed
    if free and missing(result.best.refit.runs) < NEAR:
        result = _whitened(result, own, progress)
    progress("trying other laws", 0.85)
    result = replace(result, best=restarted(result.task, result.best))
    if not result.task.by_rollouts:
        # By rollouts each law of friction was tried at all driven joints.
        result = _freed(_replaced(result))
    none, best = result.none, result.best
    if result.task.by_rollouts:
        best = without_figures(result.task, best)
    if not result.task.late() and not result.task.by_forces and not at_noise(best.refit.runs):
        if not result.task.by_rollouts:
            none, best = (to_rollouts(result.task, each) for each in (none, best))
        best = richer(result.task, best)
        if not result.task.by_rollouts and missing(best.refit.runs) > NEAR:
            best = beside(result.task, best)
        best = with_sensors(result.task, best)
    if touching and not result.task.by_rollouts:
        best = on_floor(result.task, best)
    best = simplified(best)
    if labels(best.effects) != labels(result.best.effects):
        result = replace(result, search=result.task.search(best))
    return _ranking(result, none, best)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """Where a ranking stands."""

    task: EffectSelection
    none: Finalist
    """The description with its own parameters refitted."""
    best: Finalist
    search: BeamSearch
    """Beside the best."""
    tried: tuple[Finalist, ...] = ()
    """Sets that were refitted, less the empty one."""


def _ranking(result: _Found, none: Finalist, best: Finalist) -> Ranking:
    """Return the answer of a ranking."""
    return Ranking(
        best=best,
        tried=tuple(sorted([*result.tried, none], key=lambda each: -each.evidence)),
        validation=result.task.validation,
        search=result.search,
        stopped=result.task.late(),
    )


def _begun(task: EffectSelection, none: Finalist, start: Finalist | None = None) -> _Found:
    """Return a ranking before its first round, from no effect or from a set."""
    begun = time.monotonic()
    search = task.search(none)
    # Another search, beside the answer, and the scores of held-out runs take as long each.
    deadline = task.deadline.earlier(2.0 * (time.monotonic() - begun))
    task = replace(task, prior=search.prior, deadline=deadline)
    result = _Found(task=task, none=none, best=none, search=search)
    if start is None or not start.effects or task.late():
        return result
    hypothesis = replace(task.nominal, effects=start.refit.hypothesis.effects)
    whole = task.reduced(task.refitted(hypothesis, start.refit.point))
    if not gains(none, whole, task.validation):
        return replace(result, tried=(whole,))
    return replace(result, best=whole, search=task.search(whole), tried=(whole,))


def _by_rollouts(task: EffectSelection, own: Finalist) -> _Found:
    """Return a ranking by errors of rollouts before its first round."""
    measured = _told(task.nominal.robot) and not task.validation.constrained
    task = replace(task, by_rollouts=True, by_forces=measured)
    half = replace(task, deadline=task.deadline.halfway())
    return _begun(task, half.refitted(task.nominal, own.refit.point, own.refit.runs))


def _told(robot: Robot) -> bool:
    """Return whether all forces on joints are told: of servos and in chains they are guesses."""
    return all(each.kind == "motor" for each in robot.actuators) and not robot.loops


def _searched(result: _Found, progress: Progress) -> _Found:
    """Return a ranking after rounds of its search."""
    task, base = result.task, result.best
    later, first = (FAR_ROUNDS, 0.5) if task.by_rollouts else (MOST_ROUNDS, 0.1)
    for turn, most in enumerate((MOST_FIRST, *[LATER] * later)):
        if task.late():
            break
        share = 0.8 - (0.8 - first) * 0.7**turn
        progress(f"looking for what is missing (round {turn + 1})", share)
        new, best = task.added(base, result.search, most)
        result = replace(result, best=best, tried=(*result.tried, *new))
        if labels(best.effects) == labels(base.effects):
            break
        base, search = best, task.search(best)
        task = replace(task, prior=search.prior)
        result = replace(result, task=task, search=search)
    return result


def _whitened(result: _Found, own: Finalist, progress: Progress) -> _Found:
    """Return a ranking by evidence from a set that was found by rollouts, where it is near."""
    if result.task.late():
        return result
    task, best = replace(result.task, by_rollouts=False, by_forces=False), result.best
    again = task.refitted(best.refit.hypothesis, best.refit.point, best.refit.runs)
    if missing(again.refit.runs) >= NEAR:
        return result
    start = _Found(task=task, none=own, best=again, search=task.search(again), tried=(again,))
    return _searched(start, progress)


def _replaced(result: _Found) -> _Found:
    """Return a ranking after other laws were tried in the place of those of its best set."""
    gone: set[str] = set()
    while not result.task.late():
        best = result.best
        other = result.task.replaced(best, result.search, gone)
        if other is None:
            break
        gone |= {e.label for e in best.effects} - {e.label for e in other.effects}
        result = replace(
            result, best=other, search=result.task.search(other), tried=(*result.tried, other)
        )
    return result


def restarted(task: EffectSelection, best: Finalist) -> Finalist:
    """Return a set whose laws with several ends of a refit are at the likeliest of these."""
    motions = [run.motion for run in best.refit.runs]
    laws = [(at, law) for at, law in enumerate(best.effects) if isinstance(law, JointEffect)]
    for at, other in [(at, other) for at, law in laws for other in law.restarts(motions)]:
        new = best if task.late() else task.exchanged(best, at, other)
        best = new if gains(best, new, task.validation) else best
    return best


def _freed(result: _Found) -> _Found:
    """Return a ranking whose best is no effect where the description says too much friction.

    Joints that are described too stiff or damped move as under greater gains and masses.
    """
    task, best, own = result.task, result.best, result.none.refit
    nominal = task.nominal
    low = nominal.low + 0.01 * (nominal.high - nominal.low)
    held = np.array([each.guessed for each in nominal.knobs], dtype=bool) & (own.point < low)
    # What no bound holds would stay where it is.
    if not best.effects or task.late() or not held.any():
        return result
    freed = task.refitted(nominal.freed(), own.point, own.runs)
    if freed.evidence > best.evidence and not task.validation.worse(best.losses, freed.losses):
        return replace(result, best=freed, search=task.search(freed))
    return result
