"""What survives: each finding against being absent and against its rivals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.crossvalidate import MATERIAL, gain, probabilities, validated
from morph.model.fit import Fit, fit
from morph.model.hypothesis import Hypothesis
from morph.model.screen import Suspect, screened, suspects
from morph.model.search import Contender, Search
from morph.model.trial import try_all
from morph.physics import EFFECTS
from morph.physics.effect import Effect

RIVALS = 2
"""Rivals of each finding that are fitted in its place, twins at its part first."""
MANY = 4
"""With more findings than this, each meets one rival only: the likeliest twin."""
MOST_SWAPS = 2
"""Findings that may give their place to a rival: an end to every quarrel."""


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A finding beside the models that lack it or hold a rival in its place."""

    effect: Effect
    """As in the final model."""
    without: Contender
    """The final model refitted without it."""
    rivals: tuple[Contender, ...]
    """The final model refitted with a rival in its place; the rival is the last effect."""
    chances: dict[str, float]
    """How often each is best: the finding, `none`, and each rival, by label."""


def standings(search: Search, best: Contender, seed: int) -> tuple[Contender, list[Standing]]:
    """Return the final model with only the findings that it needs, and how each stands.

    A finding accepted early may be needless once others are in: each is taken out in
    turn, the rest refitted, and it stays only if its absence surely costs. Only then
    does each meet its rivals.
    """
    if search.out_of_time():
        return best, []
    swaps = 0
    while True:
        best, without = _needed(search, best)
        kept: list[Standing] = []
        better: Contender | None = None
        for index, absent in without.items():
            if search.out_of_time():
                break
            label = best.fit.hypothesis.effects[index].label
            search.progress(f"weighing {label} against its rivals", 0.8)
            stand = _stand(search, best, absent, index, seed)
            better = _better(search, best, stand) if swaps < MOST_SWAPS else None
            if better is not None:
                break
            kept.append(stand)
        if better is None:
            return best, kept
        best, swaps = better, swaps + 1


def _needed(search: Search, best: Contender) -> tuple[Contender, dict[int, Contender]]:
    """Return the model without needless findings, and that model without each of its own.

    Links that were found to be off together were each asked beside the others already.
    """
    search.progress("taking each finding out in turn", 0.78)
    without: dict[int, Contender] = {}
    while not search.out_of_time():
        left = [
            index
            for index, effect in enumerate(best.fit.hypothesis.effects)
            if index not in without and effect.label not in search.grouped
        ]
        if not left:
            break
        absent = _without(search, best.fit, left[0])
        worth = gain(absent.losses, best.losses, max(search.tries, 1))
        needless = not (worth.sure and worth.mean >= MATERIAL)
        if needless and len(best.fit.hypothesis.effects) > 1:
            best, without = absent, {}
        else:
            without[left[0]] = absent
    return best, without


def _better(search: Search, best: Contender, stand: Standing) -> Contender | None:
    """Return the model with a rival in a finding's place, where that is surely better."""
    for rival in sorted(stand.rivals, key=lambda contender: contender.total):
        extra = max(rival.fit.hypothesis.free() - best.fit.hypothesis.free(), 0)
        won = gain(best.losses, rival.losses, search.tries)
        if won.sure and won.mean >= MATERIAL * (1 + extra):
            return rival
    return None


def _without(search: Search, found: Fit, index: int) -> Contender:
    effects = found.hypothesis.effects_at(found.point)
    fewer = replace(found.hypothesis, effects=effects[:index] + effects[index + 1 :])
    # What all links weigh can stand for a motor's strength, far along a valley.
    return _fitted(search, found, fewer, 10 if search.grouped else 3, found.cost)


def _fitted(
    search: Search, found: Fit, hypothesis: Hypothesis, iterations: int, least: float
) -> Contender:
    known = len(found.hypothesis.knobs)
    point = np.concatenate([found.point[:known], hypothesis.start[known:]])
    fitted = fit(
        hypothesis,
        search.segments,
        found.scale,
        found.weight,
        point=point,
        start=found.start,
        iterations=iterations,
        beaten_by=least,
    )
    return Contender(fit=fitted, losses=validated(fitted, search.segments, search.fold))


def _stand(search: Search, best: Contender, without: Contender, index: int, seed: int) -> Standing:
    effect = best.fit.hypothesis.effects_at(best.fit.point)[index]
    rivals = []
    for rival in _rivals(search, without.fit, effect):
        if search.out_of_time():
            break
        more = without.fit.hypothesis.adding(rival)
        rivals.append(_fitted(search, without.fit, more, 3, best.fit.cost))
    losses: dict[str, Array] = {effect.label: best.losses, "none": without.losses}
    complexity = {effect.label: best.fit.hypothesis.free(), "none": without.fit.hypothesis.free()}
    for contender in rivals:
        label = contender.fit.hypothesis.effects[-1].label
        losses[label] = contender.losses
        complexity[label] = contender.fit.hypothesis.free()
    chances = probabilities(losses, complexity, seed)
    return Standing(effect=effect, without=without, rivals=tuple(rivals), chances=chances)


def _rivals(search: Search, without: Fit, effect: Effect) -> list[Effect]:
    """Return the best other effects in a finding's place, its twins at its part first."""
    listed = suspects(screened(without.hypothesis, without.point, search.episodes))
    asked = _of_interest(without.hypothesis.robot, listed, effect)
    tried = try_all(without, search.segments, asked)
    others = [t.effect for t in tried if t.effect.label != effect.label]
    robot = without.hypothesis.robot
    twins = [o for o in others if near(robot, o, effect) and o.name in related(effect)]
    rest = [o for o in others if o not in twins]
    if len(without.hypothesis.effects) >= MANY:
        return (twins or rest)[:1]
    return (twins + rest)[:RIVALS]


def near(robot: Robot, one: Effect, other: Effect) -> bool:
    """Return whether two effects act on one part, or on a link and on what moves it."""
    if one.where == other.where:
        return True
    places = {
        joint.link: {joint.name, f"{joint.name}.position"}
        | {motor.name for motor in robot.actuators if motor.joint == joint.name}
        for joint in robot.joints
    }
    return one.where in places.get(other.where, ()) or other.where in places.get(one.where, ())


def _of_interest(robot: Robot, listed: Sequence[Suspect], effect: Effect) -> list[Suspect]:
    """Return the twins at the finding's own part, and the first suspects elsewhere."""
    return [
        suspect
        for rank, suspect in enumerate(listed)
        if rank < 6
        or (near(robot, suspect.effect, effect) and suspect.effect.name in related(effect))
    ]


def related(effect: Effect) -> set[str]:
    """Return the names of an effect's twins, and of effects that call it theirs."""
    back = {kind.name for kind in EFFECTS if effect.name in kind.twins}
    return set(effect.twins) | back


def experiment(effect: Effect, rival: str) -> str:
    """Return the experiment that tells a finding from a rival."""
    if rival == effect.name:
        return f"One part moved at a time, the others held: {effect.excited_by}"
    for kind in EFFECTS:
        if kind.name == rival and effect.name in kind.separate_by:
            return kind.separate_by[effect.name]
    other = next((kind.excited_by for kind in EFFECTS if kind.name == rival), "")
    return effect.separate_by.get(rival, f"{effect.excited_by} {other}".strip())
