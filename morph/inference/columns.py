"""Derivatives of a robot's accelerations and readings by its own parameters and by effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.inference.figures import driven, forces_between
from morph.inference.observed import Observed, shift_of
from morph.inference.sticking import slipping
from morph.model.hypothesis import Hypothesis, bare_spec
from morph.physics.dynamics import supplied
from morph.physics.effect import Effect
from morph.physics.fluid.drag import Drag
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.motion import Motion
from morph.sim.drive import all_received
from morph.sim.tangent import HINGE, SLIDE

NUDGE = 1e-3
"""Finite-difference step of an own parameter's logarithm."""


def acting(hypothesis: Hypothesis, point: Array) -> tuple[mujoco.MjModel, list[Effect]]:
    """Return a model that includes the smooth effects, and the other effects.

    Effects outside MuJoCo, dry friction and stops are the others: a linearised model lacks them.
    The description's own dry friction is among them, behind the hypothesis's.
    """
    held = [_smooth(effect, hypothesis) for effect in hypothesis.effects]
    effects = hypothesis.effects_at(point)
    inside = [effect for effect, smooth in zip(effects, held, strict=True) if smooth]
    model = replace(hypothesis, effects=tuple(inside)).at(_part(hypothesis, point, inside)).model
    beside = [effect for effect, smooth in zip(effects, held, strict=True) if not smooth]
    joints = [model.joint(at) for at in range(model.njnt) if model.jnt_type[at] in (HINGE, SLIDE)]
    described = [(joint.name, float(joint.frictionloss[0])) for joint in joints]
    return model, [*beside, *(CoulombFriction(joint=name, c=c) for name, c in described if c > 0.0)]


def _smooth(effect: Effect, hypothesis: Hypothesis) -> bool:
    """Return whether MuJoCo's model can include an effect without a constraint."""
    if effect.outside or effect.kind == "contact":
        # Laws of contact change no joint's constraints.
        return not effect.outside
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Columns:
    """Derivatives of accelerations and readings by each entry of a point."""

    hypothesis: Hypothesis
    """Own parameters and effects."""
    point: Array
    """Where the derivatives are taken, shape (entries,)."""
    model: mujoco.MjModel
    """The model there, with the smooth effects."""
    turned: list[mujoco.MjModel]
    """The model with each own parameter a little larger."""
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
        return cls(hypothesis=hypothesis, point=point, model=model, turned=turned, nudged=nudged)

    def along(self, seen: Observed) -> tuple[Array, Array]:
        """Return columns [errors, entries] of accelerations and of readings along a run.

        Shapes (samples, dofs, 1 + entries) and (samples, channels, 1 + entries).
        """
        about = seen.about
        force, shift = self.forces(seen)
        moved = about.tangent.mobility @ force
        errors = -about.acceleration[:, :, None]
        return (
            np.concatenate([errors, moved], axis=2),
            np.concatenate([about.error[:, :, None], shift], axis=2),
        )

    def forces(self, seen: Observed) -> tuple[Array, Array]:
        """Return what each entry changes of generalized forces and of readings along a run.

        N m or N, shape (samples, dofs, entries), and shape (samples, channels, entries).
        """
        motion, zero = seen.motion, np.zeros_like(seen.about.error)
        own = forces_between(self.model, self.turned, motion) / NUDGE
        forces, shifts = [], [zero] * len(self.turned)
        held = [each for each in self.nudged if each.change is None]
        base = _supplied(self.model, motion) if held else np.zeros_like(motion.velocity)
        beside = self._beside(seen)
        for each in self.nudged:
            if each.change is None:
                change, shift = _supplied(each.model, motion) - base, zero
            else:
                before, after = each.change
                change = beside[after] - beside[before]
                shift = shift_of([after], motion) - shift_of([before], motion)
            forces.append(change[:, :, None] / each.step)
            shifts.append(shift / each.step)
        empty = np.zeros((*zero.shape, 0))
        return (
            np.concatenate([own, *forces], axis=2),
            np.stack(shifts, axis=2) if shifts else empty,
        )

    def _beside(self, seen: Observed) -> dict[Effect, Array]:
        """Return forces of effects outside the model, before and after each nudge."""
        changes = [each.change for each in self.nudged if each.change is not None]
        results: dict[Effect, Array] = {}
        for first in dict.fromkeys(before for before, _ in changes):
            shapes = [first, *(after for before, after in changes if before == first)]
            if type(first).command is not Effect.command:
                results |= {effect: self._commanded(effect, seen) for effect in shapes}
            elif first.kind == "sensor":
                results |= dict.fromkeys(shapes, np.zeros_like(seen.motion.position))
            else:
                # Laws with a memory are followed together.
                whole = type(first).regressors(shapes, seen.motion)
                parts = np.split(whole, len(shapes), axis=2)
                slips = np.broadcast_to(slipping(first, seen.motion), len(whole))[:, None]
                for effect, part in zip(shapes, parts, strict=True):
                    results[effect] = np.where(slips, part @ effect.coefficients, 0.0)
        return results

    def _commanded(self, effect: Effect, seen: Observed) -> Array:
        """Return the actuators' generalized force by commands that one effect alone changed."""
        command = all_received([effect], self.hypothesis.robot, seen.sent, seen.run.step)
        return driven(self.model, replace(seen.motion, command=command))


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
    return supplied(model, motion.qpos, motion.velocity, motion.acceleration, motion.command)


def forces_by(shapes: Sequence[Effect], motion: Motion, beside: Sequence[Effect]) -> Array:
    """Return the force of an effect at some shapes by its strengths, (samples, dofs, strengths).

    A fluid that streams acts through the drags that are there.

    Args:
        shapes: The effect.
        motion: The motion.
        beside: Effects that are there.
    """
    if type(shapes[0]) is FluidCurrent:
        return shapes[0].through([each for each in beside if isinstance(each, Drag)], motion)
    return shapes[0].regressors(shapes, motion)
