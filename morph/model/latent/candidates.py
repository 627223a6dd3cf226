"""Effects that a model may lack, ranked by linear algebra about what was inferred without them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.hypothesis import Hypothesis, same_kind
from morph.model.knobs import Knob
from morph.model.latent.infer import Inferred
from morph.model.latent.normal import band
from morph.physics import EFFECTS
from morph.physics.effect import Effect

KINDS = ("joint", "actuator", "sensor")
"""Kinds of effects that are looked for: those of a body of hinges and slides in air."""

SAME = {"torque_scale": "gain", "viscous_friction": "damping"}
"""Effects that say the same as a figure of the description, where it has that figure."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """An effect at a place, and what it promises."""

    effect: Effect
    """With the strength that one linear step gives it."""
    gain: float
    """Log evidence that this step wins."""


def places(robot: Robot, knobs: Sequence[Knob]) -> tuple[Effect, ...]:
    """Return every effect at every place of a robot that its knobs do not already say."""
    said = {(knob.what, knob.part) for knob in knobs}
    return tuple(
        kind.at(where)
        for kind in EFFECTS
        if kind.kind in KINDS
        for where in kind.suspects(robot)
        if (SAME.get(kind.name, ""), where) not in said
    )


def ranked(base: Inferred, effects: Sequence[Effect]) -> tuple[Candidate, ...]:
    """Return the candidates with a gain above zero, the best first.

    Each is added at the least strength that is felt and at the values it names for scanning; the
    runs' normal equations about the base, with its column beside the others, tell where one step
    would lead. Only transitions are simulated, never a run.
    """
    found = []
    for effect in effects:
        if any(same_kind(effect, each) for each in base.hypothesis.effects):
            continue
        tries = [_step(base, start) for start in _starts(effect)]
        best = max(tries, key=lambda each: each.gain)
        if best.gain > 0.0:
            found.append(best)
    return tuple(sorted(found, key=lambda each: -each.gain))


def _starts(effect: Effect) -> list[Effect]:
    """Return an effect where its slope is taken: a little, and at each value to scan."""
    first = effect.strengths[0] if effect.strengths else ""
    known = {each.name: each for each in effect.parameters()}
    if first not in known:
        return [effect]
    scanned = known[first].scan[::2]
    return [effect, *(replace(effect, **{first: value}) for value in scanned)]  # type: ignore[type-var]


def _step(base: Inferred, effect: Effect) -> Candidate:
    """Return where one Gauss-Newton step leads that moves the states and this effect alone."""
    added = base.hypothesis.adding(effect)
    own = len(base.point)
    point = np.concatenate([base.point, added.start[own:]])
    transit = replace(base.transit, hypothesis=added)
    hessian = np.diag(added.trust)
    slope = -added.trust * np.concatenate([base.point, np.zeros(len(point) - own)])
    cost = 0.0
    for run, state in zip(base.runs, base.states, strict=True):
        each = band(transit.slopes(point, run, state), state, run.state, base.trust)
        hessian, slope = hessian + each.hessian, slope + each.slope
        cost += each.cost - each.reach
    change = _bounded(hessian, slope, added, point, own)
    gain = float(slope @ change - 0.5 * change @ hessian @ change) - cost
    reached = _own(base)
    moved = np.clip(point[own:] + change[own:], added.low[own:], added.high[own:])
    occam = 0.5 * float(
        np.linalg.slogdet(hessian)[1]
        - np.linalg.slogdet(hessian[:own, :own])[1]
        - np.log(added.trust[own:]).sum()
    )
    return Candidate(
        effect=added.effects_at(np.concatenate([base.point, moved]))[-1],
        gain=gain - reached - occam,
    )


def _own(base: Inferred) -> float:
    """Return what the same step wins without the candidate, by the same count."""
    return -sum(each.cost - each.reach for each in base.bands)


def _bounded(hessian: Array, slope: Array, hypothesis: Hypothesis, point: Array, own: int) -> Array:
    """Return the step, the candidate's parameters kept within their bounds."""
    change = np.linalg.solve(hessian, slope)
    kept = np.clip(point[own:] + change[own:], hypothesis.low[own:], hypothesis.high[own:])
    change[own:] = kept - point[own:]
    rest = slope[:own] - hessian[:own, own:] @ change[own:]
    change[:own] = np.linalg.solve(hessian[:own, :own], rest) if own else rest
    return change
