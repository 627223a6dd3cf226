"""Findings of a ranking: parameters with intervals, and how probable each is beside its rivals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from morph.arrays import Mask
from morph.body.robot import Robot
from morph.inference.quadratic import LogPosterior, information
from morph.inference.rank import Ranking
from morph.inference.remains import Remains
from morph.model.diagnosis import Estimate, Finding, Rival
from morph.physics import EFFECTS
from morph.physics.body.external_push import ExternalPush
from morph.physics.effect import SLIDING, Effect, Parameter

TEMPERATURE = 2.0
"""By what differences of evidence are divided: laws in tables are not those of robots, and errors
are not normal."""
MOST_RIVALS = 3
"""Rivals of a finding that are listed, and single effects where there is none."""
SURE, DOUBTED = 0.85, 0.75
"""Most probability of a finding, as laws that are not compared may do as well; and with a parameter
at a bound or known beforehand alone. Set by hand on opened cases of `experiments.concealed`."""
UNSURE = 0.4
"""Most with intervals of all strengths that hold no effect: 6 of 18 of these were right on opened
cases, 101 of 143 of the others."""
NORMAL90 = 1.645
"""Standard deviations from the middle of a normal distribution to an end of its 90 % interval."""


def findings(ranking: Ranking, remains: Remains) -> tuple[Finding, ...]:
    """Return the effects of the best set, what lowers the error most first.

    An effect's probability is against nothing and against every other effect in its place, in
    Gram space about the best refit; where physics without a name remains, names are less sure.

    Args:
        ranking: Sets of effects, refitted.
        remains: What the best of them leaves.
    """
    best, channels = ranking.best, len(ranking.validation.segments.measurement.channels)
    robot = best.refit.hypothesis.robot
    estimated, sure = estimates(best.about)
    listed = []
    for at, effect in enumerate(best.effects):
        entries, change = best.refit.removal(at)
        none, others = ranking.search.instead(effect.label, entries, change)
        odds = np.exp(np.minimum([none, *(each[1] for each in others)], 0.0) / TEMPERATURE)
        chance = (1.0 - 0.5 * remains.probability) / (1.0 + float(odds.sum()))
        fewer = [each for each in range(len(best.effects)) if each != at]
        (losses,) = ranking.validation.losses_of(best.about, best.refit.runs, [fewer])
        gains = losses - best.losses
        fold = ranking.validation.segments.episode
        slide = _on_slide(robot, effect)
        rivals = [
            Rival(effect=o.name, kind=o.kind, where=o.where, probability=chance * float(odd))
            for (o, _), odd in zip(others[:MOST_RIVALS], odds[1:], strict=False)
            if odd > 0.01
        ]
        nearest = rivals[0].effect if rivals else (effect.twins[0] if effect.twins else "")
        acting = [
            episode
            for number, episode in enumerate(ranking.validation.segments.episodes)
            if (getattr(effect, "run", "") in ("", episode.name))
            and (gains[fold == number].sum() > 0.0 or effect.passing)
        ]
        reported = effect
        if isinstance(effect, ExternalPush) and acting and acting[0].begin is not None:
            reported = effect.within(acting[0].recording.name, acting[0].begin)
        parameters = {
            known.name: _in_units(
                _shifted(estimated[entry], reported, effect, known.name), known, slide
            )
            for known, entry in zip(effect.free(), entries, strict=True)
        }
        most = SURE if sure[entries].all() else DOUBTED
        listed.append(
            Finding(
                effect=reported,
                probability=min(chance, UNSURE if _idle_within(effect, parameters) else most),
                episodes=tuple(dict.fromkeys(episode.name for episode in acting)),
                parameters=parameters,
                rivals=tuple(rivals),
                separate_by=experiment(effect, nearest),
                gain=float(-np.expm1(-2.0 * gains.mean() / channels)),
                slide=slide,
            )
        )
    return tuple(sorted(listed, key=lambda finding: -finding.gain))


def suspects(ranking: Ranking) -> dict[str, float]:
    """Return how probable each of the likeliest single effects is where none was found.

    If one of the dictionary is missing after all; by the label, likeliest first.

    Args:
        ranking: Sets of effects of which the best is empty.
    """
    singles = [each for each in ranking.search.sets(1) if len(each.effects) == 1]
    gains = np.array([each.gain for each in singles])
    odds = np.exp((gains - gains.max(initial=-np.inf)) / TEMPERATURE)
    total = float(odds.sum())
    return {
        each.effects[0].label: float(odd) / total
        for each, odd in zip(singles[:MOST_RIVALS], odds, strict=False)
    }


def estimates(about: LogPosterior) -> tuple[list[Estimate], Mask]:
    """Return each entry of a point with its 90 % interval, and which are known from the runs.

    The interval is the wider of two: by the curvature of the log posterior at its `TEMPERATURE`,
    and by the jackknife over folds, which holds where errors are not as the model of the
    disturbance says. Of what acts in one run alone, as a push, it is that by the curvature.

    Source: Efron 1982, The jackknife, the bootstrap and other resampling plans, eq. 3.5.

    Args:
        about: The quadratic about the likeliest point.
    """
    hypothesis, point = about.hypothesis, about.point
    low, high = hypothesis.low, hypothesis.high
    free, trust = low < high, information(hypothesis)
    slack = 1e-3 * np.minimum(high - low, np.abs(point) + 1e-9)
    at_bound = free & ((point <= low + slack) | (point >= high - slack))
    moving = free & ~at_bound
    # What neither readings nor a prior tell may be anything within its bounds, evenly.
    even = np.where(free & (trust == 0.0), 12.0 / np.maximum(high - low, 1e-150) ** 2, 0.0)
    inner = about.inner() + np.diag(even)
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))[moving]
    inverse = np.linalg.pinv(inner[np.ix_(moving, moving)] / np.outer(scale, scale), hermitian=True)
    variance = np.zeros(len(point))
    variance[moving] = np.diag(inverse) / scale**2
    folds = len(about.grams)
    steps = np.stack([about.without_fold(fold).step(moving)[0] for fold in range(folds)])
    jackknife = (folds - 1) / folds * np.sum((steps - steps.mean(axis=0)) ** 2, axis=0)
    # Without the run of a push nothing is known of it.
    passing = [e.passing for e in hypothesis.effects_at(point) for _ in e.free()]
    jackknife[len(hypothesis.knobs) :][passing] = 0.0
    width = NORMAL90 * np.sqrt(np.maximum(TEMPERATURE * variance, jackknife))
    # What the prior alone says leaves its own variance.
    prior_only = moving & (variance * (trust + even) > 0.9)
    stiff = np.maximum(np.diag(inner), 1e-300)
    width = np.where(at_bound, NORMAL90 * np.sqrt(TEMPERATURE / stiff), width)
    found = [
        Estimate(
            value=float(point[at]),
            low90=float(np.clip(point[at] - width[at], low[at], high[at])),
            high90=float(np.clip(point[at] + width[at], low[at], high[at])),
            unit="-",
            bounded=bool(at_bound[at]),
            prior_only=bool(prior_only[at]),
        )
        for at in range(len(point))
    ]
    return found, ~(at_bound | prior_only)


def factors(about: LogPosterior) -> dict[str, Estimate]:
    """Return the factors on the description's own figures, by name; see `estimates`."""
    estimated, _ = estimates(about)
    return {
        knob.name: replace(
            each,
            value=float(np.exp(each.value)),
            low90=float(np.exp(each.low90)),
            high90=float(np.exp(each.high90)),
        )
        for knob, each in zip(about.hypothesis.knobs, estimated, strict=False)
    }


def experiment(effect: Effect, rival: str) -> str:
    """Return the experiment that tells a finding from a rival."""
    if rival == effect.name:
        return f"One part moved at a time, the others held: {effect.excited_by}"
    for kind in EFFECTS:
        if kind.name == rival and effect.name in kind.separate_by:
            return kind.separate_by[effect.name]
    other = next((kind.excited_by for kind in EFFECTS if kind.name == rival), "")
    return effect.separate_by.get(rival, f"{effect.excited_by} {other}".strip())


def _on_slide(robot: Robot, effect: Effect) -> bool:
    if effect.kind == "actuator":
        return robot.actuator(effect.where).effort_unit == "N"
    name = effect.where.removesuffix(".position")
    return any(joint.name == name and joint.kind == "slide" for joint in robot.joints)


def _idle_within(effect: Effect, parameters: Mapping[str, Estimate]) -> bool:
    """Return whether the interval of every strength holds the value that does nothing.

    Strengths without such a value, as a wave's phase or where a weight is, do not count.
    """
    free = [each for each in effect.free() if each.name in effect.strengths]
    strengths = [each for each in free if each.neutral is not None]
    idle = []
    for each in strengths:
        found, neutral = parameters[each.name], each.neutral or 0.0
        # Of a limit or a stiffness without end, that is its greatest.
        held = found.low90 <= neutral <= found.high90
        idle.append(found.high90 >= 0.99 * each.high if each.reciprocal else held)
    return bool(idle) and all(idle)


def _shifted(estimate: Estimate, reported: Effect, effect: Effect, name: str) -> Estimate:
    """Return an estimate of a part of a run as one of the whole: times count from its start."""
    if reported is effect:
        return estimate
    by = getattr(reported, name) - getattr(effect, name)
    value, low, high = estimate.value + by, estimate.low90 + by, estimate.high90 + by
    return replace(estimate, value=value, low90=low, high90=high)


def _in_units(estimate: Estimate, known: Parameter, slide: bool) -> Estimate:
    if known.reciprocal:
        value, low, high = (
            float(np.clip(1.0 / max(each, 1e-300), known.low, known.high))
            for each in (estimate.value, estimate.high90, estimate.low90)
        )
        estimate = replace(estimate, value=value, low90=low, high90=high)
    return replace(estimate, unit=SLIDING.get(known.unit, known.unit) if slide else known.unit)
