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

from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist, labels, under
from morph.inference.observed import missing
from morph.inference.search import Prior, Search
from morph.inference.validate import FAR, Validation, at_noise
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect

Progress = Callable[[str, float], None]
"""Told what is being done and the share of the work that is behind, 0 to 1."""
MOST_FIRST = 4
"""Most effects, or laws at every joint, that the first search adds."""
NEAR = 0.3
"""The same of a set found by output error, below which the whitened likelihood refits it, to see
whether readings are then explained to their noise."""
LATER = 2
"""Most that each later search adds."""
MOST_ROUNDS, FAR_ROUNDS = 3, 1
"""Most of these searches, and most by output error, which takes long."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking:
    """Sets of effects that were refitted."""

    best: Finalist
    """The one that explains the runs best and of which every effect is needed."""
    tried: tuple[Finalist, ...]
    """Those that were compared under one criterion, the best by evidence first; the empty set is
    among them."""
    validation: Validation
    """The stretches on which they were compared."""
    search: Search
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
        known: Effects whose fixed parameters are known, such as a paddle's edge. They are looked
            for instead of those at the same places with defaults.
        progress: Told what is being done, and the share of the work that is behind.
        deadline: Time of the monotonic clock, about that of the answer. No step of a refit begins
            after it, less what a last search and held-out scores take.
    """
    task = EffectSelection(
        nominal=nominal,
        episodes=episodes,
        known=known,
        validation=Validation.of(episodes),
        prior=Prior(alone={}),
        deadline=deadline,
    )
    # Whatever the time: without own figures refitted there is no answer.
    task, deadline = replace(task, deadline=math.inf), task.deadline
    none = own = task.refitted(nominal, nominal.start)
    if missing(own.refit.runs) >= FAR:
        task = replace(task, by_rollouts=True)
        none = task.refitted(nominal, own.refit.point, own.refit.runs)
    begun = time.monotonic()
    search = task.search(none)
    # Another search, beside the answer, and the scores of held-out runs take as long each.
    deadline -= 2.0 * (time.monotonic() - begun)
    task = replace(task, prior=search.prior, deadline=deadline)
    task, tried, best, search = _searched(task, none, search, progress)
    if not task.by_rollouts:
        none = own = functools.reduce(under, tried, none)
        if not tried and not at_noise(own.refit.runs) and not task.late():
            # The model of the missing force is wrong: the search goes on by errors of rollouts.
            task = replace(task, by_rollouts=True)
            none = task.refitted(nominal, own.refit.point, own.refit.runs)
            task, tried, best, search = _searched(task, none, task.search(none), progress)
    if task.by_rollouts and missing(best.refit.runs) < NEAR and not task.late():
        whitened, found = replace(task, by_rollouts=False), best.refit
        again = whitened.refitted(found.hypothesis, found.point, found.runs)
        if missing(again.refit.runs) < NEAR:
            search = whitened.search(again)
            task, more, best, search = _searched(whitened, again, search, progress)
            none, tried = own, [again, *more]
    progress("trying other laws", 0.85)
    gone: set[str] = set()
    # By rollouts each law of friction was tried at all driven joints.
    while not (task.by_rollouts or task.late()) and (other := task.replaced(best, search, gone)):
        gone |= {e.label for e in best.effects} - {e.label for e in other.effects}
        best, search = other, task.search(other)
        tried.append(best)
    if best.effects and not (task.by_rollouts or task.late()):
        # Joints that are described too stiff or damped move as under greater gains and masses.
        freed = task.refitted(nominal.freed(), nominal.start, none.refit.runs)
        if freed.evidence > best.evidence and not task.validation.worse(best.losses, freed.losses):
            best, search = freed, task.search(freed)
    stopped = task.late()
    if not stopped and not task.by_rollouts and not at_noise(best.refit.runs):
        none, best = (task.refitted_to_rollouts(each) for each in (none, best))
    ordered = tuple(sorted([*tried, none], key=lambda each: -each.evidence))
    return Ranking(
        best=best, tried=ordered, validation=task.validation, search=search, stopped=stopped
    )


def _searched(
    task: EffectSelection, base: Finalist, search: Search, progress: Progress
) -> tuple[EffectSelection, list[Finalist], Finalist, Search]:
    """Return what is known of a task after rounds of a search from a set on, and their results.

    These are the sets that were refitted, the best of them or the first, and a search beside it.
    """
    tried: list[Finalist] = []
    later, first = (FAR_ROUNDS, 0.5) if task.by_rollouts else (MOST_ROUNDS, 0.1)
    for turn, most in enumerate((MOST_FIRST, *[LATER] * later)):
        if task.late():
            break
        share = 0.8 - (0.8 - first) * 0.7**turn
        progress(f"looking for what is missing (round {turn + 1})", share)
        new, best = task.added(base, search, most)
        tried += new
        same, base = labels(best.effects) == labels(base.effects), best
        if same:
            break
        search = task.search(base)
        task = replace(task, prior=search.prior)
    return task, tried, base, search
