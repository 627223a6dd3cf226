"""Sets of effects that were refitted, and which of two explains more."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.inference.explained import certain, evidence_decides
from morph.inference.quadratic import LogPosterior
from morph.inference.refit import Refit
from morph.inference.refit import under as refit_under
from morph.inference.validate import Validation
from morph.physics import EFFECTS
from morph.physics.effect import Effect

LIKELIER = 3.0
"""Gain in evidence, nats, of a set with no more effects: another law in the place of one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Finalist:
    """A set of effects, refitted to the runs beside the description's own parameters."""

    refit: Refit
    """At its likeliest point."""
    price: float
    """Negative log prior of its effects, nats."""
    losses: Array
    """Loss of each stretch in rollouts of the model fitted to the other folds, (segments,)."""
    fitted: Array
    """The same of the model fitted to all of them, where readings are explained to their noise:
    parameters that few runs determine are far off without one of them. Elsewhere `losses`."""
    about: LogPosterior
    """The log posterior about the refit, by folds."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects with their parameters."""
        return self.refit.effects

    @property
    def evidence(self) -> float:
        """Log evidence and log prior, nats, up to a constant."""
        return self.refit.evidence - self.price


def under(one: Finalist, other: Finalist) -> Finalist:
    """Return a set under the disturbances of another where the readings are likelier so."""
    return replace(one, refit=refit_under(one.refit, other.refit))


def gains(before: Finalist, new: Finalist, validation: Validation) -> bool:
    """Return whether a set of effects explains more than another.

    Rollouts decide where physics without a name remains. Where readings are explained to their
    noise the model of the disturbance holds, and evidence decides that rollouts do not refute.
    """
    gain, runs = new.evidence - before.evidence, new.refit.runs
    if validation.sure(before.losses, new.losses):
        return gain > 0.0
    if validation.worse(before.losses, new.fitted):
        return False
    if len(new.effects) <= len(before.effects):
        return gain > LIKELIER and evidence_decides(runs)
    more = [each for each in new.effects if each.label not in labels(before.effects)]
    return certain(gain, runs, event=all(each.passing for each in more))


def better(one: Finalist, other: Finalist, validation: Validation) -> Finalist:
    """Return the likelier of two, unless the other is surely better in rollouts."""
    first, second = sorted((one, other), key=lambda each: -each.evidence)
    return second if validation.sure(first.fitted, second.losses) else first


def simplified(result: Finalist) -> Finalist:
    """Return a set with the simpler law in the place of each that reduces to it.

    Of Stribeck friction that does not fade, Coulomb friction of the same level stays.
    """
    for at, effect in enumerate(result.effects):
        simple = next((kind for kind in EFFECTS if kind.name == effect.simpler), None)
        if simple is None or not reduces(effect):
            continue
        law = effect.simplified(simple.at(effect.where))
        if law.label in labels(result.effects):
            continue
        refit, about, (first, *others) = result.refit, result.about, result.refit.removal([at])[0]
        effects = (*result.effects[:at], law, *result.effects[at + 1 :])
        hypothesis = replace(refit.hypothesis, effects=effects)
        point = np.delete(refit.point, others)
        point[first] = hypothesis.start[first]
        gone = [1 + entry for entry in others]
        grams = np.delete(np.delete(about.grams, gone, axis=1), gone, axis=2)
        about = replace(about, hypothesis=hypothesis, point=point, grams=grams)
        rank = about.step()[1]
        evidence = refit.evidence + 0.5 * (refit.rank - rank) * math.log(about.readings)
        refit = replace(refit, hypothesis=hypothesis, point=point, rank=rank, evidence=evidence)
        result = replace(result, refit=refit, about=about)
    return result


def reduces(effect: Effect) -> bool:
    """Return whether a law reduces to its simpler one: its further strengths are zero."""
    return bool(effect.simpler) and len(effect.strengths) > 1 and not effect.coefficients[1:].any()


def labels(effects: Sequence[Effect]) -> frozenset[str]:
    """Return the labels of effects."""
    return frozenset(effect.label for effect in effects)
