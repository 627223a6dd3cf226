"""Ranking of sets of effects by how well they explain a robot's runs.

The description is refitted to the runs and linearised along them. Every effect at every place and
shape gives columns; their Gram matrix in the metric of the readings scores each set beside the
description's own figures. The best are refitted, and the search goes on from the best refit.
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
    without_figures,
)
from morph.inference.contact import at_stops, touches
from morph.inference.effect_selection import EffectSelection
from morph.inference.explained import at_noise
from morph.inference.finalist import Finalist, gains, labels, simplified, under
from morph.inference.observed import missing
from morph.inference.search import BeamSearch, Prior
from morph.inference.validate import FAR, FARTHEST, Validation
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
MOST_ROUNDS, FAR_ROUNDS = 3, 1
"""Most of these searches, and most by output error, which takes long."""


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
        """The description with its own figures refitted."""
        return next(each for each in self.tried if not each.effects)


def ranked(
    nominal: Hypothesis,
    episodes: Sequence[Episode],
    known: Sequence[Effect] = (),
    *,
    progress: Progress = lambda what, share: None,
    deadline: float = math.inf,
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
        progress: Told what is being done, and the share of the work that is behind.
        deadline: Time of the monotonic clock, about that of the answer: less what a last search
            and held-out scores take, no step of a refit begins after it.
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
    own = replace(task, deadline=math.inf).refitted(nominal, nominal.start)
    told = _told(nominal.robot) and not validation.constrained
    most = 0.0 if tossed else FAR if told else FARTHEST
    far = missing(own.refit.runs) >= most
    found = _searched(_by_rollouts(task, own) if far else _begun(task, own), progress)
    if not far:
        own = functools.reduce(under, found.tried, own)
        found = replace(found, none=own)
        if not found.tried and not at_noise(own.refit.runs) and not found.task.late():
            # The model of the missing force is wrong: the search goes on by errors of rollouts.
            found = _searched(_by_rollouts(replace(found.task, deadline=deadline), own), progress)
    free = found.task.by_rollouts and not tossed
    if free and missing(found.best.refit.runs) < NEAR:
        found = _whitened(found, own, progress)
    progress("trying other laws", 0.85)
    found = replace(found, best=restarted(found.task, found.best))
    if not found.task.by_rollouts:
        # By rollouts each law of friction was tried at all driven joints.
        found = _freed(_replaced(found))
    none, best = found.none, found.best
    if found.task.by_rollouts:
        best = without_figures(found.task, best)
    if not found.task.late() and not found.task.by_forces and not at_noise(best.refit.runs):
        if not found.task.by_rollouts:
            none, best = (to_rollouts(found.task, each) for each in (none, best))
        best = richer(found.task, best)
        if not found.task.by_rollouts and missing(best.refit.runs) > NEAR:
            best = beside(found.task, best)
    if touching and not found.task.by_rollouts:
        best = on_floor(found.task, best)
    best = simplified(best)
    if labels(best.effects) != labels(found.best.effects):
        found = replace(found, search=found.task.search(best))
    return Ranking(
        best=best,
        tried=tuple(sorted([*found.tried, none], key=lambda each: -each.evidence)),
        validation=found.task.validation,
        search=found.search,
        stopped=found.task.late(),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """Where a ranking stands."""

    task: EffectSelection
    none: Finalist
    """The description with its own figures refitted."""
    best: Finalist
    search: BeamSearch
    """Beside the best."""
    tried: tuple[Finalist, ...] = ()
    """Sets that were refitted, less the empty one."""


def _begun(task: EffectSelection, none: Finalist) -> _Found:
    """Return a ranking before its first round."""
    begun = time.monotonic()
    search = task.search(none)
    # Another search, beside the answer, and the scores of held-out runs take as long each.
    deadline = task.deadline - 2.0 * (time.monotonic() - begun)
    task = replace(task, prior=search.prior, deadline=deadline)
    return _Found(task=task, none=none, best=none, search=search)


def _by_rollouts(task: EffectSelection, own: Finalist) -> _Found:
    """Return a ranking by errors of rollouts before its first round."""
    told = _told(task.nominal.robot) and not task.validation.constrained
    task = replace(task, by_rollouts=True, by_forces=told)
    half = replace(task, deadline=0.5 * (time.monotonic() + task.deadline))
    return _begun(task, half.refitted(task.nominal, own.refit.point, own.refit.runs))


def _told(robot: Robot) -> bool:
    """Return whether all forces on joints are told: of servos and in chains they are guesses."""
    return all(each.kind == "motor" for each in robot.actuators) and not robot.loops


def _searched(found: _Found, progress: Progress) -> _Found:
    """Return a ranking after rounds of its search."""
    task, base = found.task, found.best
    later, first = (FAR_ROUNDS, 0.5) if task.by_rollouts else (MOST_ROUNDS, 0.1)
    for turn, most in enumerate((MOST_FIRST, *[LATER] * later)):
        if task.late():
            break
        share = 0.8 - (0.8 - first) * 0.7**turn
        progress(f"looking for what is missing (round {turn + 1})", share)
        new, best = task.added(base, found.search, most)
        found = replace(found, best=best, tried=(*found.tried, *new))
        if labels(best.effects) == labels(base.effects):
            break
        base, search = best, task.search(best)
        task = replace(task, prior=search.prior)
        found = replace(found, task=task, search=search)
    return found


def _whitened(found: _Found, own: Finalist, progress: Progress) -> _Found:
    """Return a ranking by evidence from a set that was found by rollouts, where it is near."""
    if found.task.late():
        return found
    task, best = replace(found.task, by_rollouts=False, by_forces=False), found.best
    again = task.refitted(best.refit.hypothesis, best.refit.point, best.refit.runs)
    if missing(again.refit.runs) >= NEAR:
        return found
    start = _Found(task=task, none=own, best=again, search=task.search(again), tried=(again,))
    return _searched(start, progress)


def _replaced(found: _Found) -> _Found:
    """Return a ranking after other laws were tried in the place of those of its best set."""
    gone: set[str] = set()
    while not found.task.late():
        best = found.best
        other = found.task.replaced(best, found.search, gone)
        if other is None:
            break
        gone |= {e.label for e in best.effects} - {e.label for e in other.effects}
        found = replace(
            found, best=other, search=found.task.search(other), tried=(*found.tried, other)
        )
    return found


def restarted(task: EffectSelection, best: Finalist) -> Finalist:
    """Return a set whose laws with several ends of a refit are at the likeliest of these."""
    motions = [run.motion for run in best.refit.runs]
    laws = [(at, law) for at, law in enumerate(best.effects) if isinstance(law, JointEffect)]
    for at, other in [(at, other) for at, law in laws for other in law.restarts(motions)]:
        new = best if task.late() else task.exchanged(best, at, other)
        best = new if gains(best, new, task.validation) else best
    return best


def _freed(found: _Found) -> _Found:
    """Return a ranking whose best is no effect where the description says too much friction.

    Joints that are described too stiff or damped move as under greater gains and masses.
    """
    task, best, own = found.task, found.best, found.none.refit
    nominal = task.nominal
    low = nominal.low + 0.01 * (nominal.high - nominal.low)
    held = np.array([each.guessed for each in nominal.knobs], dtype=bool) & (own.point < low)
    # What no bound holds would stay where it is.
    if not best.effects or task.late() or not held.any():
        return found
    freed = task.refitted(nominal.freed(), own.point, own.runs)
    if freed.evidence > best.evidence and not task.validation.worse(best.losses, freed.losses):
        return replace(found, best=freed, search=task.search(freed))
    return found
