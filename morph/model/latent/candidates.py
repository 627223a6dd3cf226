"""Effects that a model may lack, ranked by linear algebra about what was inferred without them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.hypothesis import Hypothesis, same_kind
from morph.model.latent.infer import Inferred
from morph.model.latent.run import Run
from morph.model.latent.sparse import likelihood_of, precisions, weighed
from morph.model.latent.subsets import precision_of
from morph.model.latent.transition_model import Transit, TransitionSlopes
from morph.model.nuisance_parameters import Knob
from morph.physics import EFFECTS
from morph.physics.effect import Effect

KINDS = ("joint", "actuator", "sensor")
"""Kinds of effects that are looked for: those of a body of hinges and slides in air."""

SAME = {"torque_scale": "gain", "viscous_friction": "damping"}
"""Effects that say the same as a figure of the description, where it has that figure."""


@dataclass(frozen=True, kw_only=True)
class CandidateEffect:
    """An effect at a place, and what it promises."""

    effect: Effect
    """With the strength that one linear step gives it."""
    score: float
    """Log probability that this step leads to, on the scale of `weighed`."""


def places(robot: Robot, knobs: Sequence[Knob]) -> tuple[Effect, ...]:
    """Return every effect at every place of a robot that its knobs do not already say."""
    names = {(knob.what, knob.part) for knob in knobs}
    return tuple(
        kind.at(where)
        for kind in EFFECTS
        if kind.kind in KINDS
        for where in kind.suspects(robot)
        if (SAME.get(kind.name, ""), where) not in names
    )


def ranked(base: Inferred, effects: Sequence[Effect]) -> tuple[CandidateEffect, ...]:
    """Return the candidates that would be felt, the best first.

    Each is added where it does nothing, and at the values that it names for scanning; the runs'
    normal equations about the base, with its column beside the others, tell where one step would
    lead, with the fewest figures changed. Only transitions are simulated, never a run.

    Args:
        base: What was inferred without them, every figure free.
        effects: The candidates.
    """
    results = []
    for effect in effects:
        if any(same_kind(effect, each) for each in base.hypothesis.effects):
            continue
        steps = [_step(base, start) for start in _starts(effect)]
        felt = [step for step in steps if step is not None]
        if felt:
            results.append(max(felt, key=lambda each: each.score))
    score = {each.effect.label: each.score for each in results}
    # What a law says with its further parameters idle, the simpler one says.
    results = [
        each
        for each in results
        if score.get(f"{each.effect.simpler}@{each.effect.where}", -np.inf) < each.score - 1.0
    ]
    return tuple(sorted(results, key=lambda each: -each.score))


def _starts(effect: Effect) -> list[Effect]:
    """Return an effect where its slope is taken: doing nothing, and at values to scan."""
    first = effect.strengths[0] if effect.strengths else ""
    known = {each.name: each for each in effect.parameters()}
    if first not in known:
        return [effect]
    scanned = known[first].scan[::2]
    return [effect, *(replace(effect, **{first: value}) for value in scanned)]  # type: ignore[type-var]


def _step(base: Inferred, effect: Effect) -> CandidateEffect | None:
    """Return where one step leads that adds this effect; None if its bounds forbid it."""
    added = base.hypothesis.adding(effect)
    own = len(base.point)
    point = np.concatenate([base.point, added.start[own:]])
    transit = replace(base.transit, hypothesis=added)
    bands = tuple(
        _beside(transit, point, run, state, known).band(state, run.state, base.trust)
        for run, state, known in zip(base.runs, base.states, base.slopes, strict=True)
    )
    likelihood = likelihood_of(bands, point)
    best = weighed(likelihood, added, point)[0]
    free, trusted, known = precisions(added)
    shift = np.concatenate([np.zeros(known), point[known:]])
    precision = precision_of(best.changed, free, trusted, known)
    about = likelihood.about(-shift).with_prior(np.zeros(len(shift)), 1.0 / precision)
    reached = shift + about.mean
    kept = np.clip(reached[own:], added.low[own:], added.high[own:])
    stronger = added.effects_at(np.concatenate([base.point, kept]))[-1]
    if _idle(stronger):
        return None
    return CandidateEffect(effect=stronger, score=best.evidence)


def _idle(effect: Effect) -> bool:
    """Return whether its strengths are where it does nothing."""
    return bool(effect.strengths) and all(
        getattr(effect, each.name) == each.neutral
        for each in effect.parameters()
        if each.name in effect.strengths
    )


def _beside(
    transit: Transit, point: Array, run: Run, state: Array, known: TransitionSlopes
) -> TransitionSlopes:
    """Return slopes with the last effect's columns beside those that are known already."""
    hypothesis: Hypothesis = transit.hypothesis
    own = known.parameter.shape[-1]
    nudges = hypothesis.nudge(point)
    value, shown = transit.ahead(point, run, state), transit.seen(point, state)
    moved, seen = [], []
    for at in range(own, len(point)):
        there = point + nudges[at] * np.eye(len(point))[at]
        moved.append((transit.ahead(there, run, state) - value) / nudges[at])
        seen.append((transit.seen(there, state) - shown) / nudges[at])
    return TransitionSlopes(
        value=value,
        state=known.state,
        parameter=np.concatenate([known.parameter, np.stack(moved, axis=-1)], axis=-1),
        seen=shown,
        seen_parameter=np.concatenate([known.seen_parameter, np.stack(seen, axis=-1)], axis=-1),
    )
