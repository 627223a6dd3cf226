"""Ranking of sets of effects by how well they explain a robot's runs; nothing is simulated.

The description is refitted to the runs and linearised along them. Every effect at every place and
shape gives columns; their Gram matrix in the metric of the readings scores each set beside the
description's own figures. The best are refitted, and the search goes on from the best refit.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from morph.inference.dictionary import search_beside
from morph.inference.finalist import CERTAIN, Finalist, better, gains, under
from morph.inference.quadratic import LogPosterior, quadratic
from morph.inference.refit import Refit, refitted
from morph.inference.refit import under as refit_under
from morph.inference.search import Explanation, Prior, Search
from morph.inference.validate import Validation, needed
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect

Progress = Callable[[str, float], None]
"""Told what is being done and the share of the work that is behind, 0 to 1."""
SIMULATED = 6
"""How many of the likeliest sets, and of the likeliest single effects, are simulated."""
FINALISTS = 2
"""How many of those with the least error are refitted, beside the likeliest."""
DIVERGED = 0.5
"""By how much a set may raise the mean loss before it is refitted, nats a stretch and joint."""
MOST = 4
"""Most effects, or laws at every joint, that the first search adds."""
LATER, MOST_ROUNDS = 2, 3
"""Most that each later search adds, and most of these searches."""
LIKELIER, REPLACED = 10.0, 3
"""Nats by which a law must be likelier than another to be tried in its place, and most trials."""
STEPS = 2
"""Most Gauss-Newton steps of a refit, of own figures alone and of a finalist."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking:
    """Sets of effects that were refitted."""

    best: Finalist
    """The one that explains the runs best and of which every effect is needed."""
    tried: tuple[Finalist, ...]
    """All of them, the best by evidence first; the empty set is among them."""
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
        deadline: Time of the monotonic clock after which no refit begins.
    """
    task = _Task(
        nominal=nominal,
        episodes=episodes,
        known=known,
        validation=Validation.of(episodes),
        prior=Prior(alone={}),
        deadline=deadline,
    )
    refit = refitted(nominal, nominal.start, episodes, rounds=STEPS)
    none = best = task.finalist(refit, task.about(refit))
    search, base, tried = task.search(best), best, []
    task = replace(task, prior=search.prior)
    for turn, most in enumerate((MOST, *[LATER] * MOST_ROUNDS)):
        progress(f"looking for what is missing (round {turn + 1})", 0.8 - 0.7 * 0.7**turn)
        new, best = task.added(base, search, most)
        tried += new
        none = functools.reduce(under, new, none)
        if best.effects == base.effects or task.late():
            break
        search, base = task.search(best), best
        task = replace(task, prior=search.prior)
    if best.effects != base.effects:
        search = task.search(best)
    progress("trying other laws", 0.85)
    gone: set[str] = set()
    while not task.late() and (other := task.replaced(best, search, gone)) is not None:
        gone |= {e.label for e in best.effects} - {e.label for e in other.effects}
        best, search = other, task.search(other)
        tried.append(best)
    stopped = task.late()
    ordered = tuple(sorted([*tried, none], key=lambda each: -each.evidence))
    return Ranking(
        best=best, tried=ordered, validation=task.validation, search=search, stopped=stopped
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Task:
    """What is ranked, and how sets of effects are refitted and compared."""

    nominal: Hypothesis
    episodes: Sequence[Episode]
    known: Sequence[Effect]
    validation: Validation
    prior: Prior
    deadline: float

    def late(self) -> bool:
        """Return whether no refit may begin any more."""
        return time.monotonic() > self.deadline

    def search(self, base: Finalist) -> Search:
        """Return a search for effects to add to a set."""
        prior = self.prior if self.prior.alone else None
        return search_beside(base.refit, self.known, prior, self.validation.blocks)

    def about(self, refit: Refit) -> LogPosterior:
        """Return the log posterior about a refit, by folds."""
        blocks = self.validation.blocks
        return quadratic(refit.hypothesis, refit.point, refit.runs, blocks=blocks)

    def finalist(self, refit: Refit, about: LogPosterior) -> Finalist:
        """Return a refit with its price and its losses."""
        whole = list(range(len(refit.effects)))
        (losses,) = self.validation.losses_of(about, refit.runs, [whole])
        price = self.prior.price({effect.label for effect in refit.effects})
        return Finalist(refit=refit, price=price, losses=losses)

    def added(self, base: Finalist, search: Search, most: int) -> tuple[list[Finalist], Finalist]:
        """Return larger sets that were refitted, and the best of them or the one before.

        Args:
            base: A set.
            search: What might be added to it.
            most: Most effects, or laws at every joint, that are added.
        """
        tried: list[Finalist] = []
        gained: list[Finalist] = []
        done = {_labels(base.effects)}
        for found in _proposals(search, search.sets(most), base, self.validation):
            if self.late():
                break
            start = replace(self.nominal, effects=(*base.effects, *found.effects))
            # A larger set may have been reduced to this one.
            if _labels(start.effects) in done:
                continue
            own = base.refit.point + found.own
            point = np.concatenate([own, start.start[len(own) :]])
            refit = refitted(start, point, self.episodes, origin=base.refit, rounds=STEPS)
            refit = refit_under(refit, base.refit)
            about = self.about(refit)
            new = self.reduced(self.finalist(refit, about), about)
            tried.append(new)
            done |= {_labels(start.effects), _labels(new.effects)}
            base, *gained = (under(each, new) for each in (base, *gained))
            if gains(base, new, self.validation):
                gained.append(new)
        if not gained:
            return tried, base
        return tried, functools.reduce(lambda a, b: better(a, b, self.validation), gained)

    def reduced(self, whole: Finalist, about: LogPosterior) -> Finalist:
        """Return a set without the effects that rollouts do not need, if that is not worse."""
        refit, validation = whole.refit, self.validation
        kept, losses = needed(about, validation, refit.runs, certain=CERTAIN)
        idle = any(validation.idle(effect) for effect in whole.effects)
        if len(kept) == len(whole.effects) or (validation.worse(whole.losses, losses) and not idle):
            return whole
        hypothesis, point = about.reduced(kept)
        anew = refitted(hypothesis, point, self.episodes, before=refit.runs, rounds=STEPS)
        about = self.about(anew)
        fewer = self.finalist(anew, about)
        if validation.worse(whole.losses, fewer.losses) and not idle:
            return whole
        # A time that the refit has shortened is no more to be claimed than one found short.
        return self.reduced(fewer, about) if any(map(validation.idle, fewer.effects)) else fewer

    def replaced(self, best: Finalist, search: Search, gone: Set[str]) -> Finalist | None:
        """Return a set with another law in the place of one: a likelier, or a simpler one.

        What was found first was found beside all that had not been found yet. A simpler law is
        taken where rollouts are not surely worse.

        Args:
            best: The set.
            search: Beside it.
            gone: Labels of effects that were replaced before.
        """
        rivals: list[tuple[float, int, Effect]] = []
        for at, effect in enumerate(best.effects):
            _, every = search.instead(effect.label, *best.refit.removal(at))
            others = [each for each in every if each[0].label not in gone]
            rivals += [(gain, at, other) for other, gain in others[:1] if gain > LIKELIER]
            simple = f"{effect.simpler}@{effect.where}"
            strength = effect.coefficients[:1]
            rivals += [(g, at, o.with_strengths(strength)) for o, g in others if o.label == simple]
        for _, at, other in sorted(rivals, key=lambda each: -each[0])[:REPLACED]:
            effects = (*best.effects[:at], other, *best.effects[at + 1 :])
            start = replace(best.refit.hypothesis, effects=effects)
            own = len(start.knobs)
            point = np.concatenate([best.refit.point[:own], start.start[own:]])
            refit = refitted(start, point, self.episodes, before=best.refit.runs, rounds=STEPS)
            about = self.about(refit)
            new = self.finalist(refit, about)
            if self.prefers(best, new, best.effects[at], other):
                return self.reduced(new, about)
        return None

    def prefers(self, best: Finalist, new: Finalist, effect: Effect, other: Effect) -> bool:
        """Return whether a set is better with another law in the place of an effect.

        Parameters that a law has more than its simpler one must show in rollouts.
        """
        if other.name == effect.simpler:
            return not self.validation.worse(best.losses, new.losses)
        if other.simpler == effect.name and not self.validation.sure(best.losses, new.losses):
            return False
        return gains(best, new, self.validation)


def _labels(effects: Sequence[Effect]) -> frozenset[str]:
    return frozenset(effect.label for effect in effects)


def _proposals(
    search: Search,
    sets: Sequence[Explanation],
    base: Finalist,
    validation: Validation,
) -> list[Explanation]:
    """Return the sets to refit: the likeliest, and those with the least error in rollouts."""
    some = [each for each in sets if each.effects and each.gain > 0.0]
    alone = [each for each in some if len(each.members) == 1]
    laws = dict(search.prior.together)
    # Stiction mimics lost torque: friction at every driven joint is tried though it gains little.
    all_over = [each for each in sets if each.gain > -5.0 and _labels(each.effects) in laws]
    groups = {_labels(each.effects): each for each in all_over[::-1]}
    listed: dict[tuple[int, ...], Explanation] = {
        each.members: each for each in [*some[:SIMULATED], *alone[:SIMULATED], *groups.values()]
    }
    hypothesis, now, losses = base.refit.hypothesis, float(base.losses.mean()), {}
    for members, found in listed.items():
        points = []
        for fold in range(len(search.levels[0].folds)):
            own, effects = search.without_fold(found, fold)
            more = replace(hypothesis, effects=(*hypothesis.effects, *effects))
            point = np.concatenate([base.refit.point + own, more.start[len(own) :]])
            points.append(np.clip(point, more.low, more.high))
        losses[members] = float(validation.losses(more, [points], base.refit.runs).mean())
    by_rollouts = sorted(listed.values(), key=lambda each: losses[each.members])
    # A stiff spring diverges in long steps. So may the likeliest set, far from the base.
    most = now + DIVERGED * len(hypothesis.robot.joints)
    stable = [each for each in by_rollouts if losses[each.members] < most]
    likeliest = sorted(by_rollouts, key=lambda each: -each.gain)[:1]
    chosen = {each.members: each for each in [*likeliest, *stable[:FINALISTS]]}
    return list(chosen.values())
