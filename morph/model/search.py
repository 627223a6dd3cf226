"""The search for left-out physics: add the surest effect, refit, and ask again."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from morph.arrays import Array, Integers
from morph.model.crossvalidate import MATERIAL, Gain, folds, gain, validated
from morph.model.episodes import Episode
from morph.model.fit import Fit, fit, measure, rescaled
from morph.model.hypothesis import Hypothesis
from morph.model.screen import Suspect, screened, suspects
from morph.model.segments import Segments
from morph.model.shooting import predict
from morph.model.together import Together, together
from morph.model.trial import Tried, try_all
from morph.physics.effect import Effect

FINALISTS = 3
"""Suspects that are fitted in full each round."""
SCREENED = 20
"""Suspects that screening passes on to rollouts each round."""
ROUGHLY = 1.5
"""How far a cost to first order may be off where much is to change."""
MOST_FINDINGS = 2
"""Findings a joint, and no fewer than six in all: what lacks more lacks a model."""
AT_NOISE = 1.1
"""Mean squared error, in units of the noise, below which nothing is left to explain."""

Progress = Callable[[str, float], None]
"""Told what is being done and the share of the work that is behind, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class Contender:
    """A fitted model and its cross-validated losses."""

    fit: Fit
    """The model, fitted to all training segments."""
    losses: Array
    """Cross-validated loss of each segment, shape (segments,)."""

    @property
    def total(self) -> float:
        """The sum of the losses."""
        return float(self.losses.sum())


@dataclass(frozen=True, kw_only=True)
class Round:
    """One question: what is missing beside what was found so far?"""

    before: Contender
    """The model so far."""
    finalists: tuple[Contender, ...]
    """The models with one more effect, the best first."""
    gain: Gain | None
    """What the best finalist gains."""
    accepted: bool
    """Whether that was a finding."""


@dataclass
class Search:
    """Everything that a search shares and keeps."""

    segments: Segments
    episodes: Sequence[Episode]
    progress: Progress
    deadline: float
    rounds: list[Round] = field(default_factory=list)
    looked_at: set[str] = field(default_factory=set)
    grouped: set[str] = field(default_factory=set)
    """Effects on links that were found together: each was asked beside all others."""

    @property
    def tries(self) -> int:
        """How many effects at places were looked at."""
        return len(self.looked_at)

    stopped: bool = False

    def out_of_time(self) -> bool:
        """Return whether the budget is spent, and remember that something was cut short."""
        self.stopped = self.stopped or time.monotonic() > self.deadline
        return self.stopped

    @property
    def fold(self) -> Integers:
        """Each segment's fold."""
        return folds(self.segments)

    def refit(self, nominal: Hypothesis) -> Contender:
        """Return the description refitted with nothing added."""
        read = predict(nominal, self.segments, [nominal.start], [self.segments.start])[0]
        first = fit(nominal, self.segments, *measure(self.segments, read), iterations=3)
        return self._polished(first)

    def run(self, refitted: Contender) -> Contender:
        """Return the model with every effect that is sure, in the order found."""
        best = refitted
        most = max(6, MOST_FINDINGS * len(refitted.fit.hypothesis.robot.joints))
        while len(best.fit.hypothesis.effects) < most and not self.out_of_time():
            if self._at_noise(best):
                break
            asked = self._ask(best)
            self.rounds.append(asked)
            if not asked.accepted:
                break
            best = self._polished(asked.finalists[0].fit)
        return best

    def _ask(self, best: Contender) -> Round:
        found = best.fit
        known = len(found.hypothesis.effects)
        self.progress(f"looking for what is missing (round {known + 1})", 0.75 - 0.55 * 0.8**known)
        listed = suspects(screened(found.hypothesis, found.point, self.episodes))
        self.looked_at |= {suspect.effect.label for suspect in listed}
        tried = try_all(found, self.segments, _shortlist(listed))
        links = together(found, self.segments)
        if links is not None and tried and links.cost > ROUGHLY * tried[0].cost:
            links = None
        finalists: list[Contender] = []
        for candidate in _with_simpler(tried) if links is None else tried[:1]:
            if self.out_of_time():
                break
            least = min((c.fit.cost for c in finalists), default=math.inf)
            finalists.append(self._with(found, candidate.effect, candidate.point, least))
        finalists.sort(key=lambda c: c.total)
        finalists = _simplest_first(finalists, self.tries)
        if not finalists:
            return Round(before=best, finalists=(), gain=None, accepted=False)
        if links is not None and not self.out_of_time():
            whole = self._fit_links(found, links)
            if self._beats(whole, finalists[0]):
                finalists = [whole, *finalists]
        won = gain(best.losses, finalists[0].losses, self.tries)
        new = [effect.label for effect in finalists[0].fit.hypothesis.effects[known:]]
        felt = _felt(finalists[0].fit, len(new))
        accepted = won.sure and won.mean >= MATERIAL and felt
        self.grouped |= set(new) if accepted and len(new) > 1 else set()
        return Round(before=best, finalists=tuple(finalists), gain=won, accepted=accepted)

    def _with(self, found: Fit, effect: Effect, point: Array, least: float = math.inf) -> Contender:
        more = replace(found.hypothesis, effects=found.hypothesis.effects_at(point)).adding(effect)
        extended = np.concatenate([point, more.start[len(point) :]])
        fitted = fit(
            more,
            self.segments,
            found.scale,
            found.weight,
            point=extended,
            start=found.start,
            iterations=4,
            beaten_by=least,
        )
        return Contender(fit=fitted, losses=validated(fitted, self.segments, self.fold))

    def _fit_links(self, found: Fit, links: Together) -> Contender:
        """Return the model with effects on many links at once, fitted in full."""
        fitted = fit(
            links.hypothesis,
            self.segments,
            found.scale,
            found.weight,
            point=links.point,
            start=found.start,
        )
        return Contender(fit=fitted, losses=validated(fitted, self.segments, self.fold))

    def _beats(self, whole: Contender, alone: Contender) -> bool:
        """Return whether many effects surely do better than one, in units of what they leave."""
        read = predict(whole.fit.hypothesis, self.segments, [whole.fit.point], [whole.fit.start])
        units = measure(self.segments, read[0])
        one, all_ = (
            validated(rescaled(each.fit, self.segments, *units), self.segments, self.fold)
            for each in (alone, whole)
        )
        extra = len(whole.fit.hypothesis.effects) - len(alone.fit.hypothesis.effects)
        better = gain(one, all_, self.tries)
        return better.sure and better.mean >= min(MATERIAL * extra, 0.5)

    def _polished(self, found: Fit) -> Contender:
        """Return a fit carried to its end, with each joint's error in units of its present size.

        To its end: a candidate must not gain by what the model before it left undone.
        """
        read = predict(found.hypothesis, self.segments, [found.point], [found.start])[0]
        fitted = fit(
            found.hypothesis,
            self.segments,
            *measure(self.segments, read),
            point=found.point,
            start=found.start,
            iterations=12,
            tolerance=2e-4,
        )
        return Contender(fit=fitted, losses=validated(fitted, self.segments, self.fold))

    def _at_noise(self, best: Contender) -> bool:
        read = predict(best.fit.hypothesis, self.segments, [best.fit.point], [best.fit.start])[0]
        squared = np.where(
            self.segments.valid[..., None], (self.segments.reading - read) ** 2, 0.0
        ).sum(axis=(0, 1))
        in_noise = squared / self.segments.valid.sum() / self.segments.noise**2
        return bool((in_noise < AT_NOISE).all())


def _shortlist(listed: Sequence[Suspect]) -> list[Suspect]:
    """Return the first suspects, and every law at least at its best place.

    Screening sees a law's force, not what it does to a rollout: a law that it ranks low
    everywhere still gets one hearing.
    """
    kept = list(listed[:SCREENED])
    laws = {suspect.effect.name for suspect in kept}
    for suspect in listed[SCREENED:]:
        if suspect.effect.name not in laws:
            kept.append(suspect)
            laws.add(suspect.effect.name)
    return kept


def _felt(found: Fit, new: int) -> bool:
    """Return whether a new effect has a strength whose 90 % interval leaves neutral out."""
    free = [known for effect in found.hypothesis.effects[-new:] for known in effect.free()]
    low, high = found.intervals()
    bounds = zip(free, low[-len(free) :], high[-len(free) :], strict=True)
    return any(p.neutral is not None and not (a <= p.neutral <= b) for p, a, b in bounds)


def _with_simpler(tried: Sequence[Tried]) -> list[Tried]:
    """Return the finalists, each with the simpler law that it becomes at the same place."""
    kept = list(tried[:FINALISTS])
    for candidate in tried[:FINALISTS]:
        for other in tried[FINALISTS:]:
            if (other.effect.name, other.effect.where) == (
                candidate.effect.simpler,
                candidate.effect.where,
            ):
                kept.append(other)
    return kept


def _simplest_first(finalists: list[Contender], tries: int) -> list[Contender]:
    """Put first the simplest finalist that the best one does not surely beat."""
    if not finalists:
        return finalists
    best = finalists[0]
    for other in sorted(finalists, key=lambda c: (c.fit.hypothesis.free(), c.total)):
        if other.fit.hypothesis.free() >= best.fit.hypothesis.free():
            continue
        spared = best.fit.hypothesis.free() - other.fit.hypothesis.free()
        beaten = gain(other.losses, best.losses, tries)
        if not (beaten.sure and beaten.mean >= MATERIAL * spared):
            return [other, *(c for c in finalists if c is not other)]
    return finalists
