"""Refit of a description's own figures and of effects to runs, by Gauss-Newton."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.inference.bounded import bounded
from morph.inference.figures import driven, force_between
from morph.inference.filter import whitened
from morph.inference.linearise import supplied
from morph.inference.observed import Observed, observed, shift_of
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis, bare_spec
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.sim.drive import received

NUDGE = 1e-3
"""Finite-difference step of an own figure's logarithm."""
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


def acting(hypothesis: Hypothesis, point: Array) -> tuple[mujoco.MjModel, list[Effect]]:
    """Return a model that includes the smooth effects, and the other effects.

    Effects outside MuJoCo, dry friction and stops are the others: a linearised model lacks them.
    """
    held = [_smooth(effect, hypothesis) for effect in hypothesis.effects]
    effects = hypothesis.effects_at(point)
    inside = [effect for effect, smooth in zip(effects, held, strict=True) if smooth]
    model = replace(hypothesis, effects=tuple(inside)).at(_part(hypothesis, point, inside)).model
    return model, [effect for effect, smooth in zip(effects, held, strict=True) if not smooth]


def _smooth(effect: Effect, hypothesis: Hypothesis) -> bool:
    """Return whether MuJoCo's model can include an effect without a constraint."""
    if effect.outside:
        return False
    spec = bare_spec(hypothesis.robot, hypothesis.step).copy()
    before = _constraints(spec)
    effect.with_strengths(np.ones(len(effect.strengths))).edit(spec)
    return _constraints(spec) == before


def _constraints(spec: Any) -> list[tuple[Any, ...]]:
    """Return what makes constraints: dry friction and stops of all joints."""
    return [(joint.frictionloss, joint.limited, *joint.range) for joint in spec.joints]


def _part(hypothesis: Hypothesis, point: Array, effects: Sequence[Effect]) -> Array:
    """Return the point of a hypothesis with some effects only, which already have its values."""
    part = replace(hypothesis, effects=tuple(effects))
    return np.concatenate([point[: len(hypothesis.knobs)], part.start[len(hypothesis.knobs) :]])


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Columns:
    """Derivatives of accelerations and readings by each entry of a point."""

    hypothesis: Hypothesis
    model: mujoco.MjModel
    turned: list[mujoco.MjModel]
    """The model with each own figure a little larger."""
    nudged: list[_Nudged]
    """Each parameter of the effects a little larger."""

    @classmethod
    def of(cls, hypothesis: Hypothesis, point: Array) -> Columns:
        """Return the derivatives about a point."""
        own, steps = len(hypothesis.knobs), hypothesis.nudge(point)
        axes = np.eye(len(point))
        model, beside = acting(hypothesis, point)
        nudged = []
        for at in range(own, len(point)):
            step = float(steps[at])
            there, changed = acting(hypothesis, point + step * axes[at])
            pairs = [(a, b) for a, b in zip(beside, changed, strict=True) if a != b]
            nudged.append(_Nudged(step=step, model=there, change=pairs[0] if pairs else None))
        turned = [acting(hypothesis, point + NUDGE * axis)[0] for axis in axes[:own]]
        return cls(hypothesis=hypothesis, model=model, turned=turned, nudged=nudged)

    def along(self, seen: Observed) -> tuple[Array, Array]:
        """Return columns [errors, entries] of accelerations and of readings along a run.

        Shapes (samples, dofs, 1 + entries) and (samples, channels, 1 + entries).
        """
        motion, about = seen.motion, seen.about
        samples, dofs = about.position.shape
        forces = [force_between(self.model, each, motion) / NUDGE for each in self.turned]
        shown = [about.error, *([np.zeros_like(about.error)] * len(self.turned))]
        held = [each for each in self.nudged if each.change is None]
        base = _supplied(self.model, motion) if held else np.zeros((samples, dofs))
        beside = self._beside(seen)
        for each in self.nudged:
            if each.change is None:
                change, shift = _supplied(each.model, motion) - base, np.zeros_like(about.error)
            else:
                before, after = each.change
                change = beside[after] - beside[before]
                shift = shift_of([after], motion) - shift_of([before], motion)
            forces.append(change / each.step)
            shown.append(shift / each.step)
        stacked = np.stack([np.zeros((samples, dofs)), *forces], axis=2)
        moved = about.tangent.jacobian[:, :, 2 * dofs :] @ stacked
        moved[:, :, 0] = -about.acceleration
        return moved, np.stack(shown, axis=2)

    def _beside(self, seen: Observed) -> dict[Effect, Array]:
        """Return forces of effects outside the model, before and after each nudge."""
        changes = [each.change for each in self.nudged if each.change is not None]
        found: dict[Effect, Array] = {}
        for first in dict.fromkeys(before for before, _ in changes):
            shapes = [first, *(after for before, after in changes if before == first)]
            if type(first).command is not Effect.command:
                found |= {effect: self._commanded(effect, seen) for effect in shapes}
            elif first.kind == "sensor":
                found |= dict.fromkeys(shapes, np.zeros_like(seen.motion.position))
            else:
                # Laws with a memory are followed together.
                whole = type(first).regressors(shapes, seen.motion)
                parts = np.split(whole, len(shapes), axis=2)
                for effect, part in zip(shapes, parts, strict=True):
                    found[effect] = part @ effect.coefficients
        return found

    def _commanded(self, effect: Effect, seen: Observed) -> Array:
        """Return the actuators' generalized force by commands that one effect alone changed."""
        command = [
            received([effect], actuator.name, seen.sent[:, at], seen.run.step)
            for at, actuator in enumerate(self.hypothesis.robot.actuators)
        ]
        return driven(self.model, replace(seen.motion, command=np.stack(command, axis=1)))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Nudged:
    """A hypothesis with one parameter of its effects a little larger."""

    step: float
    """By how much."""
    model: mujoco.MjModel
    """The model at that parameter."""
    change: tuple[Effect, Effect] | None
    """The effect before and after, where it is outside the model; else None."""


def _supplied(model: mujoco.MjModel, motion: Motion) -> Array:
    return supplied(model, motion.position, motion.velocity, motion.acceleration, motion.command)
