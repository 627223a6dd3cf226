"""A description's own figures and effects at their likeliest, by Gauss and Newton."""

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
from morph.inference.observed import Observed, force_of, observed, shift_of
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis, bare_spec
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.sim.drive import received

NUDGE = 1e-3
"""Step of the difference by an own figure's logarithm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refit:
    """A hypothesis about some runs, linearised at a point."""

    hypothesis: Hypothesis
    """Own figures and effects that are free."""
    point: Array
    """Where."""
    runs: Sequence[Observed]
    """The runs as smoothed there."""
    evidence: float
    """Logarithm of the evidence, without the price of what was tried."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects there."""
        return self.hypothesis.effects_at(self.point)


def seen(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    before: Sequence[Observed] | None = None,
) -> list[Observed]:
    """Return runs as a hypothesis explains them at a point.

    Args:
        hypothesis: Own figures and effects.
        point: Where.
        episodes: The runs.
        before: The same runs by a hypothesis that differed a little; effects that MuJoCo cannot
            hold act along its motion.
    """
    model, beside = acting(hypothesis, point)
    return [
        observed(
            model, hypothesis.robot, each, effects=beside, before=before[at] if before else None
        )
        for at, each in enumerate(episodes)
    ]


def acting(hypothesis: Hypothesis, point: Array) -> tuple[mujoco.MjModel, list[Effect]]:
    """Return a model that holds those effects that are smooth, and the others."""
    held = [_smooth(effect, hypothesis) for effect in hypothesis.effects]
    effects = hypothesis.effects_at(point)
    inside = [effect for effect, smooth in zip(effects, held, strict=True) if smooth]
    model = replace(hypothesis, effects=tuple(inside)).at(_part(hypothesis, point, inside)).model
    return model, [effect for effect, smooth in zip(effects, held, strict=True) if not smooth]


def _smooth(effect: Effect, hypothesis: Hypothesis) -> bool:
    """Whether MuJoCo holds an effect, and not as a constraint, which linearised models lack."""
    if effect.outside:
        return False
    spec = bare_spec(hypothesis.robot, hypothesis.step).copy()
    before = _constraints(spec)
    effect.with_strengths(np.ones(len(effect.strengths))).edit(spec)
    return _constraints(spec) == before


def _constraints(spec: Any) -> list[tuple[Any, ...]]:
    """Return dry friction and stops of all joints."""
    return [(joint.frictionloss, joint.limited, *joint.range) for joint in spec.joints]


def _part(hypothesis: Hypothesis, point: Array, effects: Sequence[Effect]) -> Array:
    """Return the point of a hypothesis with some effects only."""
    part = replace(hypothesis, effects=tuple(effects))
    return np.concatenate([point[: len(hypothesis.knobs)], part.start[len(hypothesis.knobs) :]])


def refitted(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    *,
    before: Sequence[Observed] | None = None,
    rounds: int = 2,
) -> Refit:
    """Return a hypothesis at its likeliest point; of some steps the best.

    Source: Bell 1994, SIAM Journal on Optimization 4(3), 626-636 (Gauss-Newton through a smoother).

    Args:
        hypothesis: Own figures and effects.
        point: Where to begin.
        episodes: The runs.
        before: The runs by a hypothesis that differed a little.
        rounds: How many steps.
    """
    # Effects act along a motion: without one it is that of the model alone.
    runs = before or seen(replace(hypothesis, effects=()), point[: len(hypothesis.knobs)], episodes)
    runs = seen(hypothesis, point, episodes, runs) if hypothesis.effects or before else runs
    best, trust = None, prior(hypothesis)
    for turn in range(rounds + 1):
        gram, logarithm = _gram(hypothesis, point, runs)
        readings = sum(int(run.about.tangent.valid.sum()) for run in runs)
        at = offset(hypothesis, point)
        inner = gram[1:, 1:] + np.diag(trust)
        along = gram[1:, 0] - trust * at
        low, high = hypothesis.low - point - 1e-9, hypothesis.high - point + 1e-9
        step, rank = bounded(inner, along, low, high)
        effects = max(0, rank - len(hypothesis.knobs))
        square = gram[0, 0] + at @ (trust * at)
        evidence = -0.5 * float(square + logarithm) - 0.5 * effects * math.log(readings)
        if best is None or evidence > best.evidence:
            best = Refit(hypothesis=hypothesis, point=point, runs=runs, evidence=evidence)
        elif turn:
            break
        if turn < rounds:
            point = np.clip(point + step, hypothesis.low, hypothesis.high)
            runs = seen(hypothesis, point, episodes, runs)
    assert best is not None
    return best


def prior(hypothesis: Hypothesis) -> Array:
    """Return one over the variance of each entry; nothing where all values are alike."""
    return np.where(np.isnan(hypothesis.likely), 0.0, hypothesis.trust)


def offset(hypothesis: Hypothesis, point: Array) -> Array:
    """Return how far a point is from what is likeliest beforehand, zero where all is alike."""
    return np.asarray(point - np.where(np.isnan(hypothesis.likely), point, hypothesis.likely))


def _gram(hypothesis: Hypothesis, point: Array, runs: Sequence[Observed]) -> tuple[Array, float]:
    """Return the Gram matrix of errors and of every entry of a point, over all runs."""
    whole, logarithm = np.zeros((1 + len(point), 1 + len(point))), 0.0
    columns = Columns.of(hypothesis, point)
    for run in runs:
        moved, shown = columns.along(run)
        about = run.about
        leaving = replace(about.disturbance, noise=run.run.noise)
        found = whitened(about.tangent, leaving, shown, moved)
        whole += found.gram
        logarithm += found.logarithm
    return whole, logarithm


@dataclass(frozen=True, kw_only=True, eq=False)
class Columns:
    """How each entry of a point acts on a run, to first order."""

    hypothesis: Hypothesis
    model: mujoco.MjModel
    turned: list[mujoco.MjModel]
    """With each own figure a little larger."""
    nudged: list[tuple[float, mujoco.MjModel, list[Effect], list[Effect]]]
    """For each entry of the effects by how much it is larger, the model then, and effects that the
    model does not hold before and after."""

    @classmethod
    def of(cls, hypothesis: Hypothesis, point: Array) -> Columns:
        """Return those about a point."""
        own, steps = len(hypothesis.knobs), hypothesis.nudge(point)
        axes = np.eye(len(point))
        model, beside = acting(hypothesis, point)
        nudged = []
        for at in range(own, len(point)):
            step = float(steps[at])
            there, changed = acting(hypothesis, point + step * axes[at])
            pairs = [(a, b) for a, b in zip(beside, changed, strict=True) if a != b]
            # What is held by the model changes it, what is not does not.
            nudged.append(
                (step, model if pairs else there, [a for a, _ in pairs], [b for _, b in pairs])
            )
        turned = [acting(hypothesis, point + NUDGE * axis)[0] for axis in axes[:own]]
        return cls(hypothesis=hypothesis, model=model, turned=turned, nudged=nudged)

    def along(self, seen: Observed) -> tuple[Array, Array]:
        """Return accelerations (samples, dofs, entries) and readings likewise, errors first."""
        motion, about = seen.motion, seen.about
        samples, dofs = about.position.shape
        forces = [force_between(self.model, each, motion) / NUDGE for each in self.turned]
        shown = [about.error, *([np.zeros_like(about.error)] * len(self.turned))]
        held = [model is not self.model for _, model, _, _ in self.nudged]
        base = _supplied(self.model, motion) if any(held) else np.zeros((samples, dofs))
        for step, model, before, after in self.nudged:
            if model is not self.model:
                change = _supplied(model, motion) - base
            else:
                change = self._beside(after, seen) - self._beside(before, seen)
            forces.append(change / step)
            shift = shift_of(after, motion) - shift_of(before, motion)
            shown.append(shift + np.zeros_like(about.error))
            shown[-1] /= step
        stacked = np.stack([np.zeros((samples, dofs)), *forces], axis=2)
        moved = about.tangent.jacobian[:, :, 2 * dofs :] @ stacked
        moved[:, :, 0] = -about.acceleration
        return moved, np.stack(shown, axis=2)

    def _beside(self, effects: Sequence[Effect], seen: Observed) -> Array:
        """Return the force of effects that the model does not hold."""
        force, motion = force_of(effects, seen.motion), seen.motion
        if any(type(effect).command is not Effect.command for effect in effects):
            command = [
                received(effects, actuator.name, seen.sent[:, at], seen.run.step)
                for at, actuator in enumerate(self.hypothesis.robot.actuators)
            ]
            force += driven(self.model, replace(motion, command=np.stack(command, axis=1)))
        return force


def _supplied(model: mujoco.MjModel, motion: Motion) -> Array:
    return supplied(model, motion.position, motion.velocity, motion.acceleration, motion.command)
