"""What rollouts say of a set of effects after its search: richer laws, further ones, fewer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist, gains, labels
from morph.inference.floor import likeliest_contact
from morph.inference.remains import remaining
from morph.inference.simulated import likeliest_sensor
from morph.physics import EFFECTS

RICHER = 0.2
"""Least mean gain in rollouts of a richer law, nats a stretch: rollouts of each set start from a
motion smoothed by it, and these alone differ by 0.1 on a disc that sticks."""
CLEAR = 0.5
"""The same of a law of a sensor: physics that is missing looks a little like a sensor that errs."""
EXPLAINED = 2.0
"""Mean squared error of rollouts over the noise's variance below which no floor is looked for."""
LATER = 2
"""Most effects, or laws at every joint, that a later search adds."""
FIGURES = ("armature", "com_offset", "link_inertia", "torque_scale")
"""Laws of what the description says, which own parameters are within their bounds."""


def richer(task: EffectSelection, result: Finalist) -> Finalist:
    """Return a set with a richer law in the place of one wherever rollouts surely err less then.

    Where the model of the missing force is not believed, a richer law that was refitted by
    it may have been far from where rollouts err least. The simpler one tells where to begin.
    """
    rollouts = replace(task, by_rollouts=True)
    for at, effect in enumerate(result.effects):
        laws = [kind for kind in EFFECTS if effect.name == kind.simpler and kind.kind == "joint"]
        if not laws or task.late():
            continue
        # The law itself begins anew too: more steps alone may lower the errors.
        more = [effect]
        for law in laws:
            strengths = np.zeros(len(law.strengths))
            strengths[: len(effect.strengths)] = effect.coefficients
            more.append(law.at(effect.where).with_strengths(strengths))
        again, *tried = [rollouts.exchanged(result, at, each) for each in more]
        same, best = (
            min(some, key=lambda each: each.losses.mean()) for some in ((result, again), tried)
        )
        gain = float((same.losses - best.losses).mean())
        if gain > RICHER and task.validation.sure(same.losses, best.losses):
            result = replace(best, refit=replace(best.refit, evidence=result.refit.evidence))
    return result


def beside(task: EffectSelection, best: Finalist) -> Finalist:
    """Return a better set of more effects, searched about one that was refitted to rollouts.

    Where much force is missing, evidence finds strengths beside which the rest does not show: of a
    joint with play, half of the rotor's inertia, beside which the play gains 15 nats, not 286.
    """
    more, _ = task.added(best, task.search(best), LATER)
    for new in more:
        if not task.late() and not labels(new.effects) <= labels(best.effects):
            new = to_rollouts(task, new)
            if gains(best, new, task.validation):
                best = new
    return best


def with_sensors(task: EffectSelection, best: Finalist) -> Finalist:
    """Return a set with laws of sensors beside it, where rollouts surely err less with them.

    Where much force is missing a filter takes what a late sensor reads for more of it, and a search
    by evidence finds a tenth of its lag.
    """
    rollouts = replace(task, by_rollouts=True)
    while not task.late() and (added := likeliest_sensor(best, task.validation, task.known)):
        refit = best.refit
        more = replace(refit.hypothesis, effects=(*best.effects, added))
        point = np.r_[refit.point, more.start[len(refit.point) :]]
        new = rollouts.refitted(more, point, refit.runs)
        gain = float((best.losses - new.losses).mean())
        if gain < CLEAR or not task.validation.sure(best.losses, new.losses):
            break
        best = replace(new, refit=replace(new.refit, evidence=refit.evidence))
    return best


def on_floor(task: EffectSelection, best: Finalist) -> Finalist:
    """Return a set with laws of the floor beside it, where rollouts surely err less with them."""
    channels = len(task.validation.segments.read)
    if np.expm1(2.0 * np.median(best.fitted) / channels) < EXPLAINED:
        return best
    if remaining(best, task.validation).chaotic:
        return best
    result = likeliest_contact(best, task.validation, float(best.losses.mean()))
    if result is None or task.late():
        return best
    refit, rollouts = best.refit, replace(task, by_rollouts=True)
    more = replace(refit.hypothesis, effects=(*best.effects, *result[1].effects))
    point = np.r_[refit.point, more.start[len(refit.point) :]]
    # More steps alone may lower the errors.
    same = rollouts.refitted(refit.hypothesis, refit.point, refit.runs)
    new = rollouts.refitted(more, point, refit.runs)
    if not task.validation.sure(same.losses, new.losses):
        return best
    return replace(new, refit=replace(new.refit, evidence=refit.evidence))


def to_rollouts(task: EffectSelection, result: Finalist) -> Finalist:
    """Return a set refitted to rollouts, unless they are surely worse then."""
    refit, rollouts = result.refit, replace(task, by_rollouts=True)
    again = rollouts.refitted(refit.hypothesis, refit.point, refit.runs)
    if task.validation.worse(result.losses, again.losses):
        return result
    fewer = rollouts.reduced(again)
    # Evidence alone speaks for what acts once: rollouts in which it acts are few.
    if not {e.label for e in again.effects if e.passing} - labels(fewer.effects):
        again = fewer
    return replace(again, refit=replace(again.refit, evidence=refit.evidence))


def without_figures(task: EffectSelection, result: Finalist) -> Finalist:
    """Return a set less changes of own parameters that rollouts do not need.

    Linearised about the set they seem needed where own parameters are at their bounds: of a joint's
    friction that is taken too small, a weak motor explains what is left. All is refitted without.
    """
    for effect in result.effects:
        if effect.name in FIGURES and len(result.effects) > 1 and not task.late():
            at = [each.label for each in result.effects].index(effect.label)
            fewer = task.exchanged(result, at, None)
            result = fewer if task.prefers(result, fewer, effect, None) else result
    return result
