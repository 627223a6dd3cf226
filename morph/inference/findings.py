"""Findings of a ranking, and how probable each is beside its rivals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.body.robot import Robot
from morph.inference.finalist import reduces
from morph.inference.intervals import TEMPERATURE, Uncertainty, in_units, shifted, widened
from morph.inference.rank import Ranking
from morph.inference.remains import Remains
from morph.inference.streaming import acting_together
from morph.model.finding import Finding, Rival
from morph.model.segments import Segments
from morph.physics import EFFECTS
from morph.physics.body.external_push import ExternalPush
from morph.physics.effect import Effect

MOST_RIVALS = 3
"""Rivals of a finding that are listed, and single effects where there is none."""
SURE, DOUBTED = 0.75, 0.7
"""Most probability of a finding, as laws that are not compared may do as well; and with a parameter
at a bound or known beforehand alone. Set by hand on development cases of `experiments.concealed`,
of which 68 of 91 of the first kind were right (`judge`, seed 23)."""
UNSURE = 0.4
"""Most with intervals of all strengths that hold no effect, of which 6 of 18 were right on opened
cases (101 of 143 of the others), and at a joint that was not read where physics is left."""


def findings(ranking: Ranking, remains: Remains) -> tuple[Finding, ...]:
    """Return the effects of the best set, what lowers the error most first.

    An effect's probability is against nothing and against every other effect in its place, in
    Gram space about the best refit; where physics without a name remains, names are less sure.

    Args:
        ranking: Sets of effects, refitted.
        remains: What the best of them leaves.
    """
    best, channels = ranking.best, len(ranking.validation.segments.read)
    robot = best.refit.hypothesis.robot
    uncertainty = Uncertainty.of(best.about)
    estimated, sure = uncertainty.estimates()
    unread = _unread(ranking.validation.segments, robot)
    listed = []
    for at, effect in enumerate(best.effects):
        entries, _ = best.refit.removal([at])
        without = best.refit.removal(acting_together(best.effects, at))
        none, others = ranking.search.instead(effect.label, *without)
        fewer = [each for each in range(len(best.effects)) if each != at]
        (losses,) = ranking.validation.losses_of(best.about, best.refit.runs, [fewer])
        gains = losses - best.losses
        if effect.kind == "contact":
            # No column tells of it: what a stretch's rollout gains is one reading.
            none, others = -float(gains.sum()), []
        # A richer law that reduces to this one is no rival.
        others = [each for each in others if each[0].simpler != effect.name or not reduces(each[0])]
        odds = np.exp(np.minimum([none, *(each[1] for each in others)], 0.0) / TEMPERATURE)
        fold = ranking.validation.segments.episode
        slide = on_slide(robot, effect)
        acting = [
            episode
            for number, episode in enumerate(ranking.validation.segments.episodes)
            if (getattr(effect, "run", "") in ("", episode.name))
            and (gains[fold == number].sum() > 0.0 or effect.passing)
        ]
        reported = effect
        if isinstance(effect, ExternalPush) and acting:
            reported = effect.within(acting[0].recording.name, acting[0].begin)
        parameters = {
            known.name: in_units(
                shifted(estimated[entry], reported, effect, known.name), known, slide
            )
            for known, entry in zip(effect.free(), entries, strict=True)
        }
        if effect.kind == "contact":
            wider = float(np.sqrt(1.0 + max(remains.in_noise, 0.0)))
            parameters = {
                known.name: widened(parameters[known.name], known, wider) for known in effect.free()
            }
        most = SURE if sure[entries].all() else DOUBTED
        estimated_there = remains.probability > 0.5 and effect.where in unread
        most = (
            UNSURE
            if estimated_there or _may_be_idle(effect, entries.tolist(), uncertainty)
            else most
        )
        chance = min(most, (1.0 - 0.5 * remains.probability) / (1.0 + float(odds.sum())))
        rivals = [
            Rival(effect=o.name, kind=o.kind, where=o.where, probability=chance * float(odd))
            for (o, _), odd in zip(others[:MOST_RIVALS], odds[1:], strict=False)
            if odd > 0.01
        ]
        nearest = rivals[0].effect if rivals else (effect.twins[0] if effect.twins else "")
        listed.append(
            Finding(
                effect=reported,
                probability=chance,
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


def experiment(effect: Effect, rival: str) -> str:
    """Return the experiment that tells a finding from a rival."""
    if rival == effect.name:
        return f"One part moved at a time, the others held: {effect.excited_by}"
    for kind in EFFECTS:
        if kind.name == rival and effect.name in kind.separate_by:
            return kind.separate_by[effect.name]
    other = next((kind.excited_by for kind in EFFECTS if kind.name == rival), "")
    return effect.separate_by.get(rival, f"{effect.excited_by} {other}".strip())


def _unread(segments: Segments, robot: Robot) -> set[str]:
    """Return joints whose motion is estimated, and their actuators."""
    space = segments.measurement
    joints = {
        name.removesuffix(".position")
        for name, guess in zip(space.channels, segments.guess, strict=True)
        if guess > 0.0
    }
    return joints | {each.name for each in robot.actuators if each.joint in joints}


def on_slide(robot: Robot, effect: Effect) -> bool:
    """Return whether an effect acts along a slide, in N and m."""
    if effect.kind == "actuator":
        return robot.actuator(effect.where).effort_unit == "N"
    name = effect.where.removesuffix(".position")
    return any(joint.name == name and joint.kind == "slide" for joint in robot.joints)


def _may_be_idle(effect: Effect, entries: Sequence[int], uncertainty: Uncertainty) -> bool:
    """Return whether all strengths may have the value that does nothing.

    Strengths without such a value, as a wave's phase or where a weight is, do not count. Of a
    limit or a stiffness without end it is the greatest, whose reciprocal is the entry.
    """
    low = uncertainty.about.hypothesis.low
    idle = {
        entry: float(low[entry]) if each.reciprocal else each.neutral
        for entry, each in zip(entries, effect.free(), strict=True)
        if each.name in effect.strengths and each.neutral is not None
    }
    return bool(idle) and uncertainty.may_be([*idle], np.array([*idle.values()]))
