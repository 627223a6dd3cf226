"""Attribute the difference of body and description to parameters and missing effects."""

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
from morph.model.latent.sparse import PRICE, SparseChanges, sparse
from morph.model.latent.subsets import Subset
from morph.model.latent.unknowns import WIDE, unknowns
from morph.physics.effect import Effect
from morph.sim.integrator import Integrator

FINALISTS = 3
"""Candidates that are fitted whole in each round."""

DOUBT = 10.0
"""How much log probability one linear step may misjudge a candidate by, and it is still fitted."""

MOST_ADDED = 3
"""Most effects that are added."""


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
    progress: Callable[[str], None] = lambda _: None,
) -> Explained:
    """Return what differs between a body and its description, by a run or a few.

    First every figure of the description may be anything. Each small set of figures is then held
    against the others as the one that changed, the rest within their trust (`unknowns.TRUSTED`),
    by linear algebra; and with the most probable set all is fitted again. Effects of the library
    are added one at a time, as long as one makes the whole more probable, its price included.

    Args:
        robot: The description.
        runs: What was observed.
        noise: Standard deviation of each observation, positions then velocities, shape (n,).
        step: Step of the simulation, s.
        integrator: What it steps with.
        effects: What the description is known to be under; their parameters are fitted too.
        candidates: Effects to look for; default all of the library that the body can be under.
        progress: Is told what is going on.

    Raises:
        DiagnosisError: There is no run, or the body floats.
    """
    knobs = unknowns(robot, WIDE)
    requested = places(robot, knobs) if candidates is None else tuple(candidates)
    hypothesis = Hypothesis(robot=robot, step=step, knobs=knobs, effects=effects)
    progress("every figure may have changed")
    result = sparse(infer(hypothesis, runs, noise, integrator=integrator), noise, 0.0)
    given = result.score - result.order[0].evidence + _evidence_of(result.order, ())
    for _ in range(MOST_ADDED):
        better = _added(result, requested, noise, progress)
        if better is None:
            break
        result = _without_idle(better, len(effects), noise)
    return Explained(
        inferred=result.held,
        differences=_differences(result.held, result.order[0], len(effects)),
        rivals=_rivals(result),
        evidence=result.score - given,
    )


def _evidence_of(order: Sequence[Subset], changed: tuple[int, ...]) -> float:
    return next(each.evidence for each in order if each.changed == changed)


def _added(
    base: SparseChanges, requested: Sequence[Effect], noise: Array, progress: Callable[[str], None]
) -> SparseChanges | None:
    """Return the base with the effect that makes it most probable, if one makes it more so."""
    price = base.price + PRICE + float(np.log(max(len(requested), 1)))
    hopeful = base.order[0].evidence - base.price + price - DOUBT
    best: SparseChanges | None = None
    tried = [each for each in ranked(base.free, requested) if each.score > hopeful][:FINALISTS]
    for candidate in tried:
        progress(f"with {candidate.effect.label}")
        free = base.free
        hypothesis = free.hypothesis.moved_to(free.point).adding(candidate.effect)
        integrator = free.transit.integrator
        more = infer(hypothesis, free.runs, noise, integrator=integrator, begin=free, steps=12)
        result = sparse(more, noise, price)
        if best is None or result.score > best.score:
            best = result
    return best if best is not None and best.score > base.score else None


def _without_idle(result: SparseChanges, given: int, noise: Array) -> SparseChanges:
    """Return what was found less an earlier effect whose part a later one plays as well."""
    effects = result.free.effects
    for at in range(given, len(effects) - 1):
        kept = (*effects[:at], *effects[at + 1 :])
        free = result.free
        hypothesis = replace(free.hypothesis, effects=kept)
        point = np.concatenate([free.point[: len(hypothesis.knobs)], _values(hypothesis)])
        integrator = free.transit.integrator
        less = infer(hypothesis, free.runs, noise, integrator=integrator, begin=free, point=point)
        fewer = sparse(less, noise, result.price * (len(kept) - given) / (len(effects) - given))
        if fewer.score > result.score:
            return fewer
    return result


def _values(hypothesis: Hypothesis) -> Array:
    """Return the parameters of a hypothesis' effects as they stand."""
    return hypothesis.start[len(hypothesis.knobs) :]


def _differences(final: Inferred, subset: Subset, given: int) -> tuple[Difference, ...]:
    deviation = 1.645 * np.sqrt(np.diag(final.covariance))
    known = len(final.hypothesis.knobs)
    lines = [
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
            lines.append(
                Difference(
                    name=final.names[at],
                    value=value,
                    low90=value - float(deviation[at]),
                    high90=value + float(deviation[at]),
                )
            )
    return tuple(lines)


def _rivals(result: SparseChanges) -> tuple[tuple[str, float], ...]:
    logs = np.array([each.evidence for each in result.order])
    weight = np.exp(logs - logs.max())
    share = weight / weight.sum()
    names = [knob.name for knob in result.free.hypothesis.knobs]
    added = [effect.label for effect in result.free.effects]
    return tuple(
        (" + ".join([*(names[at] for at in each.changed), *added]) or "nothing changed", float(p))
        for each, p in zip(result.order[:5], share[:5], strict=True)
    )
