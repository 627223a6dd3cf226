"""Findings put together: parameters with intervals, chances, rivals, experiments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from morph.arrays import Array
from morph.model.conclude import Standing, experiment
from morph.model.diagnosis import Estimate, Finding, Rival
from morph.model.evidence import Evidence
from morph.model.fit import Fit
from morph.model.together import instead
from morph.physics.effect import SLIDING, Effect


def findings(e: Evidence) -> tuple[Finding, ...]:
    """Return what was left out, what explains most first."""
    found = e.best.fit
    effects = found.hypothesis.effects_at(found.point)
    low, high = found.intervals()
    at = len(found.hypothesis.knobs)
    listed = []
    by_label = {stand.effect.label: stand for stand in e.stands}
    beside = _of_links(e)
    for effect in effects:
        stand = by_label.get(effect.label)
        estimates = {}
        slide = _on_slide(e, effect)
        for known in effect.free():
            estimates[known.name] = Estimate(
                value=float(found.point[at]),
                low90=float(low[at]),
                high90=float(high[at]),
                unit=SLIDING.get(known.unit, known.unit) if slide else known.unit,
            )
            at += 1
        listed.append(_finding(e, effect, estimates, stand, beside.get(effect.label, ())))
    return tuple(sorted(listed, key=lambda finding: -finding.gain))


def _of_links(e: Evidence) -> dict[str, list[Rival]]:
    """Return what could be said instead of each link that was found off together with others."""
    if not e.search.grouped:
        return {}
    found = instead(e.searched[1].fit, e.search.segments, e.search.grouped)
    return {
        label: [
            Rival(effect=other.name, kind=other.kind, where=other.where, probability=chance)
            for other, chance in others
        ]
        for label, others in found.items()
    }


def _on_slide(e: Evidence, effect: Effect) -> bool:
    name = effect.where.removesuffix(".position")
    return any(j.name == name and j.kind == "slide" for j in e.robot.joints)


def _finding(
    e: Evidence,
    effect: Effect,
    estimates: Mapping[str, Estimate],
    stand: Standing | None,
    beside: Sequence[Rival],
) -> Finding:
    rivals = list(beside)
    episodes: tuple[str, ...] = tuple(episode.name for episode in e.train)
    share, chance = 0.0, _by_rounds(e, effect)
    if stand is not None:
        chance = stand.chances[effect.label]
        by_label = {c.fit.hypothesis.effects[-1].label: c for c in stand.rivals}
        for label, contender in by_label.items():
            other = contender.fit.hypothesis.effects[-1]
            rivals.append(
                Rival(
                    effect=other.name,
                    kind=other.kind,
                    where=other.where,
                    probability=stand.chances[label],
                )
            )
        # The losses without the finding beside those of the best rival-free model.
        with_it = e.best.losses
        share = 1.0 - float(with_it.sum()) / float(stand.without.losses.sum() + 1e-30)
        fewer = [
            (
                e.train[i].name,
                float((stand.without.losses - with_it)[e.search.segments.episode == i].sum()),
            )
            for i in range(len(e.train))
        ]
        episodes = tuple(name for name, less in fewer if less > 0.0)
    rivals.sort(key=lambda rival: -rival.probability)
    nearest = rivals[0].effect if rivals else (effect.twins[0] if effect.twins else "")
    return Finding(
        effect=effect,
        probability=chance,
        episodes=episodes,
        parameters=estimates,
        rivals=tuple(rivals),
        separate_by=experiment(effect, nearest),
        gain=share,
        slide=_on_slide(e, effect),
    )


def chances(e: Evidence, verdict: str) -> dict[str, float]:
    """Return how probable it is that nothing is missing, something unnamed, or each finding."""
    chances = {"none": 0.0, "unknown": 0.0}
    if not e.best.fit.hypothesis.effects:
        chances["none"] = 1.0 if verdict == "consistent" else 0.0
        last = e.search.rounds[-1] if e.search.rounds else None
        if last is not None and last.finalists:
            best = last.finalists[0]
            wins = float(np.mean(_drawn(e, last.before.losses, best.losses)))
            label = best.fit.hypothesis.effects[-1].label
            # An effect that is not sure is as likely as it wins beyond a coin's toss.
            chances[label] = max(0.0, 2.0 * wins - 1.0) * 0.5
            rest = 1.0 - chances[label]
            chances["none" if verdict == "consistent" else "unknown"] = rest
        elif verdict == "unknown":
            chances["unknown"] = 1.0
        return chances
    for effect in e.best.fit.hypothesis.effects:
        chances[effect.label] = _by_rounds(e, effect)
    for stand in e.stands:
        chances[stand.effect.label] = stand.chances[stand.effect.label]
    if e.stands:
        chances["none"] = min(stand.chances["none"] for stand in e.stands)
    if verdict == "unknown":
        # The training runs speak for the findings and the held-out runs against them.
        chances = {name: 0.5 * chance for name, chance in chances.items()}
        chances["unknown"] = 0.5
    return chances


def _by_rounds(e: Evidence, effect: Effect) -> float:
    """Return how often a finding beat the model before it; 0 if no round says."""
    for asked in e.search.rounds:
        if not asked.accepted:
            continue
        had = asked.before.fit.hypothesis.effects
        new = asked.finalists[0].fit.hypothesis.effects[len(had) :]
        if effect.label in {each.label for each in new}:
            return float(np.mean(_drawn(e, asked.before.losses, asked.finalists[0].losses)))
    return 0.0


def _drawn(e: Evidence, before: Array, after: Array) -> Array:
    rng = np.random.default_rng(e.seed)
    draws = rng.integers(len(before), size=(2000, len(before)))
    return np.asarray(after[draws].sum(axis=1) < 0.98 * before[draws].sum(axis=1))


def factors(found: Fit) -> dict[str, Estimate]:
    """Return the factors on the description's own figures, by name."""
    low, high = found.intervals()
    return {
        knob.name: Estimate(
            value=float(np.exp(found.point[i])),
            low90=float(np.exp(low[i])),
            high90=float(np.exp(high[i])),
            unit="-",
        )
        for i, knob in enumerate(found.hypothesis.knobs)
    }
