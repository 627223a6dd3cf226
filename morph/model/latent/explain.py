"""What differs between a body and its description: changed figures and missing effects, named."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.hypothesis import Hypothesis
from morph.model.latent.candidates import places, ranked
from morph.model.latent.infer import Inferred, infer
from morph.model.latent.run import Run
from morph.model.latent.subsets import Likelihood, Subset, subsets
from morph.model.latent.unknowns import TRUSTED, WIDE, unknowns
from morph.physics.effect import Effect
from morph.sim.integrator import Integrator

FINALISTS = 4
"""Candidates that are fitted whole in each round."""

MOST_ADDED = 3
"""Most effects that are added."""

WORTH = 4.0
"""Log evidence that an effect must win beyond the logarithm of how many were tried."""


@dataclass(frozen=True, kw_only=True)
class Difference:
    """One thing in which a body differs from its description."""

    name: str
    """`length:pole`, or an effect's `coulomb_friction@slide:c`."""
    value: float
    """A figure's factor, or an effect's parameter."""
    low90: float
    """The lower end of a 90 % interval."""
    high90: float
    """The upper end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Explained:
    """What runs say about a body."""

    inferred: Inferred
    """The body with what changed; all else within its trust."""
    differences: tuple[Difference, ...]
    """What changed and what is missing."""
    rivals: tuple[tuple[str, float], ...]
    """The most probable explanations in words, and how probable each is among them."""
    evidence: float
    """How much more probable than the description as given they make the runs, log."""

    @property
    def robot(self) -> Robot:
        """The repaired description."""
        return self.inferred.robot

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects that it takes, those it had before included."""
        return self.inferred.effects

    @property
    def unsaid(self) -> float:
        """What it still leaves out, as a share of a typical change of speed in a period."""
        return self.inferred.unsaid


def explain(
    robot: Robot,
    runs: Sequence[Run],
    noise: Array,
    *,
    step: float,
    integrator: Integrator = "implicitfast",
    effects: tuple[Effect, ...] = (),
    candidates: Sequence[Effect] | None = None,
    told: Callable[[str], None] = lambda said: None,
) -> Explained:
    """Return what differs between a body and its description, by a run or a few.

    First every figure of the description may be anything. Then effects of the library are added,
    the one at a time that wins most evidence, as long as it wins enough. Then each small set of
    figures is held against the others as the one that changed, the rest within their trust
    (`unknowns.TRUSTED`), by linear algebra; and with the most probable set all is fitted again.

    Args:
        robot: The description.
        runs: What was observed.
        noise: Standard deviation of each observation, positions then velocities, shape (n,).
        step: Step of the simulation, s.
        integrator: What it steps with.
        effects: What the description is known to be under; their parameters are fitted too.
        candidates: Effects to look for; default all of the library that the body can be under.
        told: Is told what is going on.

    Raises:
        DiagnosisError: There is no run, or the body floats.
    """
    knobs = unknowns(robot, WIDE)
    asked = places(robot, knobs) if candidates is None else tuple(candidates)
    hypothesis = Hypothesis(robot=robot, step=step, knobs=knobs, effects=effects)
    told("every figure may have changed")
    found = infer(hypothesis, runs, noise, integrator=integrator)
    for _ in range(MOST_ADDED):
        better = _added(found, asked, noise, told)
        if better is None:
            break
        found = better
    order = _subsets(found)
    told("which figures changed")
    final = _held(found, order[0], noise)
    return Explained(
        inferred=final,
        differences=_differences(final, order[0], len(effects)),
        rivals=_rivals(found, order),
        evidence=order[0].evidence - _evidence_of(order, ()),
    )


def _added(
    base: Inferred, asked: Sequence[Effect], noise: Array, told: Callable[[str], None]
) -> Inferred | None:
    """Return the base with the effect that wins most evidence, if it wins enough."""
    tried = ranked(base, asked)[:FINALISTS]
    best: Inferred | None = None
    for candidate in tried:
        told(f"with {candidate.effect.label}")
        hypothesis = base.hypothesis.moved_to(base.point).adding(candidate.effect)
        found = infer(
            hypothesis, base.runs, noise, integrator=base.transit.integrator, begin=base, steps=12
        )
        if best is None or found.evidence > best.evidence:
            best = found
    needed = base.evidence + WORTH + np.log(max(len(asked), 1))
    return best if best is not None and best.evidence > needed else None


def _likelihood(found: Inferred) -> Likelihood:
    hessian = np.sum([each.hessian for each in found.bands], axis=0)
    slope = np.sum([each.slope for each in found.bands], axis=0)
    return Likelihood(hessian=hessian, slope=slope + hessian @ found.point)


def _subsets(found: Inferred) -> tuple[Subset, ...]:
    free = found.hypothesis.trust
    known = len(found.hypothesis.knobs)
    trusted = free.copy()
    trusted[:known] = TRUSTED**-2.0
    likelihood = _likelihood(found)
    # Effects stay where they are: only what the description says may be trusted or not.
    centred = _about(likelihood, found.point, known)
    return subsets(centred, free, trusted, known)


def _about(likelihood: Likelihood, point: Array, known: int) -> Likelihood:
    """Return the likelihood with effects' parameters counted from where they were found."""
    shift = np.concatenate([np.zeros(known), point[known:]])
    return replace(likelihood, slope=likelihood.slope - likelihood.hessian @ shift)


def _held(found: Inferred, subset: Subset, noise: Array) -> Inferred:
    """Return all fitted again, with what did not change held to the description."""
    hypothesis = found.hypothesis
    knobs = tuple(
        replace(knob, fraction=WIDE if at in subset.changed else TRUSTED)
        for at, knob in enumerate(hypothesis.knobs)
    )
    begin = found.point.copy()
    still = [at for at in range(len(knobs)) if at not in subset.changed]
    begin[still] = 0.0
    held = replace(hypothesis, knobs=knobs, effects=found.effects)
    return infer(
        held, found.runs, noise, integrator=found.transit.integrator, begin=found, point=begin
    )


def _differences(final: Inferred, subset: Subset, given: int) -> tuple[Difference, ...]:
    deviation = 1.645 * np.sqrt(np.diag(final.covariance))
    known = len(final.hypothesis.knobs)
    said = [
        Difference(
            name=final.names[at],
            value=float(np.exp(final.point[at])),
            low90=float(np.exp(final.point[at] - deviation[at])),
            high90=float(np.exp(final.point[at] + deviation[at])),
        )
        for at in subset.changed
    ]
    added = {effect.label for effect in final.effects[given:]}
    for at in range(known, len(final.point)):
        if final.names[at].rpartition(":")[0] in added:
            value = float(final.point[at])
            said.append(
                Difference(
                    name=final.names[at],
                    value=value,
                    low90=value - float(deviation[at]),
                    high90=value + float(deviation[at]),
                )
            )
    return tuple(said)


def _rivals(found: Inferred, order: Sequence[Subset]) -> tuple[tuple[str, float], ...]:
    logs = np.array([each.evidence for each in order])
    weight = np.exp(logs - logs.max())
    share = weight / weight.sum()
    names = [found.hypothesis.knobs[at].name for at in range(len(found.hypothesis.knobs))]
    added = [effect.label for effect in found.effects]
    return tuple(
        (" + ".join([*(names[at] for at in each.changed), *added]) or "nothing changed", float(p))
        for each, p in zip(order[:5], share[:5], strict=True)
    )


def _evidence_of(order: Sequence[Subset], changed: tuple[int, ...]) -> float:
    return next(each.evidence for each in order if each.changed == changed)
