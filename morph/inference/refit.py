"""Refit of a description's own figures and of effects to runs, by Gauss-Newton."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.inference.bounded import bounded
from morph.inference.columns import Columns, acting
from morph.inference.filter import whitened
from morph.inference.observed import Observed, observed
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect

SHARES = (0.3, 0.1)
"""Parts of a step that are tried where the whole step gains nothing."""
SETTLED = 1.0
"""Nats: a refit ends with a step that gains less evidence."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refit:
    """A hypothesis about some runs, linearised at a point."""

    hypothesis: Hypothesis
    """Its free own figures and effects."""
    point: Array
    """Log factors of own figures, then parameters of effects, shape (entries,)."""
    runs: Sequence[Observed]
    """The runs smoothed and linearised at the point."""
    evidence: float
    """Log evidence by Schwarz's criterion, nats, up to a constant; without prices of the search."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects at the point."""
        return self.hypothesis.effects_at(self.point)


def seen(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    before: Sequence[Observed] | None = None,
) -> list[Observed]:
    """Return runs smoothed and linearised by a hypothesis at a point.

    Args:
        hypothesis: Own figures and effects.
        point: Shape (entries,).
        episodes: The runs.
        before: The same runs by a similar hypothesis. Effects outside the model act along its
            motion; without it their forces and changes of readings are left out.
    """
    model, beside = acting(hypothesis, point)
    return [
        observed(
            model, hypothesis.robot, each, effects=beside, before=before[at] if before else None
        )
        for at, each in enumerate(episodes)
    ]


def refitted(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    *,
    origin: Refit | None = None,
    rounds: int = 2,
    least: float = -math.inf,
) -> Refit:
    """Return a hypothesis refitted to runs by Gauss-Newton steps, shortened if they gain nothing.

    Source: Bell 1994, SIAM Journal on Optimization 4(3), 626-636 (Gauss-Newton through a smoother).

    Args:
        hypothesis: Own figures and effects.
        point: The first point, shape (entries,).
        episodes: The runs.
        origin: A refit of the same hypothesis less its last effects. A first point that explains
            less than it is moved toward it.
        rounds: Most steps.
        least: Stop where the next step predicts less evidence, nats.
    """
    # Effects act along a motion: without one it is that of the model alone.
    bare = replace(hypothesis, effects=())
    runs = origin.runs if origin else seen(bare, point[: len(hypothesis.knobs)], episodes)
    runs = seen(hypothesis, point, episodes, runs) if hypothesis.effects or origin else runs
    best = _judged(hypothesis, point, runs, len(point))
    if origin is not None:
        idle = _idle(hypothesis, origin)
        price = 0.5 * (len(point) - len(origin.point)) * math.log(_readings(runs))
        for share in SHARES:
            if best.evidence >= origin.evidence - price:
                break
            near = idle + share * (point - idle)
            runs = seen(hypothesis, near, episodes, origin.runs)
            best = max(best, _judged(hypothesis, near, runs, len(point)), key=lambda r: r.evidence)
    for turn in range(rounds):
        step, rank, gained = _newton(best)
        if turn == 0:
            best = _judged(hypothesis, best.point, best.runs, rank)
        if best.evidence + gained < least:
            break
        before = best
        for share in (1.0, *SHARES):
            point = np.clip(best.point + share * step, hypothesis.low, hypothesis.high)
            found = _judged(hypothesis, point, seen(hypothesis, point, episodes, best.runs), rank)
            if found.evidence > best.evidence:
                best = found
                break
        if best is before or (share == 1.0 and best.evidence < before.evidence + SETTLED):
            break
    return best


def _idle(hypothesis: Hypothesis, origin: Refit) -> Array:
    """Return the point at which a hypothesis with further effects is that of `origin`."""
    count = len(origin.effects)
    neutral = (effect.neutral() for effect in hypothesis.effects[count:])
    point = replace(hypothesis, effects=(*hypothesis.effects[:count], *neutral)).start
    return np.concatenate([origin.point, point[len(origin.point) :]])


def _newton(at: Refit) -> tuple[Array, int, float]:
    """Return the Gauss-Newton step, the rank of its columns and the nats that it predicts."""
    hypothesis, trust = at.hypothesis, prior(at.hypothesis)
    gram = _gram(hypothesis, at.point, at.runs)
    inner = gram[1:, 1:] + np.diag(trust)
    along = gram[1:, 0] - trust * offset(hypothesis, at.point)
    low, high = hypothesis.low - at.point - 1e-9, hypothesis.high - at.point + 1e-9
    step, rank = bounded(inner, along, low, high)
    return step, rank, float(along @ step - 0.5 * step @ inner @ step)


def _judged(hypothesis: Hypothesis, point: Array, runs: Sequence[Observed], rank: int) -> Refit:
    """Return a point with its evidence, given the rank of all columns."""
    at = offset(hypothesis, point)
    evidence = -0.5 * float(at @ (prior(hypothesis) * at))
    for run in runs:
        about = run.about
        leaving = replace(about.disturbance, noise=run.run.noise)
        shown, moved = about.error[:, :, None], -about.acceleration[:, :, None]
        level = whitened(about.tangent, leaving, shown, moved)
        evidence -= 0.5 * (float(level.gram[0, 0]) + level.logarithm)
    evidence -= 0.5 * max(0, rank - len(hypothesis.knobs)) * math.log(_readings(runs))
    return Refit(hypothesis=hypothesis, point=point, runs=runs, evidence=evidence)


def _readings(runs: Sequence[Observed]) -> int:
    return sum(int(run.about.tangent.valid.sum()) for run in runs)


def prior(hypothesis: Hypothesis) -> Array:
    """Return one over the prior variance, zero where the prior is flat, shape (entries,)."""
    return np.where(np.isnan(hypothesis.likely), 0.0, hypothesis.trust)


def offset(hypothesis: Hypothesis, point: Array) -> Array:
    """Return a point less the prior mean, zero where the prior is flat, shape (entries,)."""
    return np.asarray(point - np.where(np.isnan(hypothesis.likely), point, hypothesis.likely))


def _gram(hypothesis: Hypothesis, point: Array, runs: Sequence[Observed]) -> Array:
    """Return the Gram matrix of [errors, entries of a point] over all runs."""
    columns, whole = Columns.of(hypothesis, point), np.zeros((1 + len(point), 1 + len(point)))
    for run in runs:
        moved, shown = columns.along(run)
        leaving = replace(run.about.disturbance, noise=run.run.noise)
        whole += whitened(run.about.tangent, leaving, shown, moved).gram
    return whole
