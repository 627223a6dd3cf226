"""Transitions of a run with their derivatives by state and parameters, in one batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import DiagnosisError
from morph.model.gaussian.states import ReducedEquations, Trust, band
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.sim.drive import received, sensed
from morph.sim.integrator import INTEGRATORS, Integrator
from morph.sim.rollout import Variant, rollout

NUDGE = 1e-5
"""Step of finite differences in states; RK4's rounding is 1e-15, its curvature here about 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TransitionSlopes:
    """Where every state of a run leads, what it shows, and how both change."""

    value: Array
    """f(x_t), one control period later, shape (periods, n)."""
    state: Array
    """df/dx, shape (periods, n, n)."""
    parameter: Array
    """df/dtheta, shape (periods, n, p)."""
    seen: Array
    """h(x_t), what sensors say, shape (periods + 1, n)."""
    seen_parameter: Array
    """dh/dtheta, shape (periods + 1, n, p)."""

    def band(self, state: Array, reading: Array, trust: Trust) -> ReducedEquations:
        """Return the normal equations of one run about its states, both (periods + 1, n)."""
        return band(
            state=self.state,
            unknown=self.parameter,
            seen_unknown=self.seen_parameter,
            off=state[1:] - self.value,
            missed=reading - self.seen,
            trust=trust,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Transit:
    """A hypothesis and the clock on which runs of it were recorded.

    Raises:
        DiagnosisError: The body floats, or the control period is no multiple of the step.
    """

    hypothesis: Hypothesis
    """The body with what may differ, and the effects to be fitted."""
    period: float
    """Control period, s."""
    integrator: Integrator
    """What the simulation steps with."""

    def __post_init__(self) -> None:
        """Check that states are positions and velocities, and that the clock fits."""
        robot, where = self.hypothesis.robot, f"robot {self.hypothesis.robot.name}"
        if any(joint.kind in {"free", "ball"} for joint in robot.joints):
            raise DiagnosisError(
                "states and parameters are inferred together for hinges and slides alone",
                where=where,
                fix="choose among whole models instead (morph.model.ensemble), or diagnose",
            )
        ratio = self.period / self.hypothesis.step
        if not (ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6):
            raise DiagnosisError(
                f"a control period of {self.period:g} s is no multiple of a step, "
                f"{self.hypothesis.step:g} s",
                where=where,
                fix="give a step that divides the period",
            )

    @property
    def substeps(self) -> int:
        """How many steps a control period has."""
        return round(self.period / self.hypothesis.step)

    def variant(self, point: Array) -> Variant:
        """Return the simulation at a point."""
        result = self.hypothesis.at(point)
        result.model.opt.integrator = INTEGRATORS[self.integrator]
        return result

    def ahead(self, point: Array, run: Run, state: Array) -> Array:
        """Return where each state of a run leads in one control period, (periods, n)."""
        variant = self.variant(point)
        which = np.zeros(len(run.command), dtype=np.int64)
        return np.asarray(self._rolled([variant], which, run, state[None])[0])

    def seen(self, point: Array, state: Array) -> Array:
        """Return what sensors show of states (..., n) under the effects at a point."""
        return self._seen(self.hypothesis.effects_at(point), state)

    def slopes(self, point: Array, run: Run, state: Array) -> TransitionSlopes:
        """Return where states (periods + 1, n) of a run lead, and how that changes."""
        n, p = state.shape[1], len(point)
        nudges = self.hypothesis.nudge(point)
        points = [point + nudges[k] * np.eye(p)[k] for k in range(p)]
        variants = [self.variant(each) for each in (point, *points)]
        states = np.stack([state, *(state + NUDGE * np.eye(n)[a] for a in range(n)), *[state] * p])
        of = [0] * (1 + n) + list(range(1, 1 + p))
        which = np.repeat(np.array(of, dtype=np.int64), len(run.command))
        out = self._rolled(variants, which, run, states)
        base = out[0]
        shown = self.seen(point, state)
        moved = [self.seen(each, state) for each in points]
        return TransitionSlopes(
            value=base,
            state=np.moveaxis((out[1 : 1 + n] - base) / NUDGE, 0, -1),
            parameter=_per_nudge(out[1 + n :] - base, nudges),
            seen=shown,
            seen_parameter=_per_nudge(np.array(moved).reshape(p, *shown.shape) - shown, nudges),
        )

    def _rolled(
        self,
        variants: Sequence[Variant],
        which: Integers,
        run: Run,
        states: Array,
    ) -> Array:
        """Return (blocks, periods, n), where each block of states leads."""
        periods = len(run.command)
        blocks, n = len(states), states.shape[-1]
        start = states[:, :periods].reshape(blocks * periods, n)
        given = [self._received(variant, run) for variant in variants]
        of_block = which.reshape(blocks, periods)[:, 0]
        command = np.concatenate([given[each] for each in of_block])
        half = n // 2
        q, v = rollout(variants, which, start[:, :half], start[:, half:], command)
        return np.concatenate([q[:, -1], v[:, -1]], axis=1).reshape(blocks, periods, n)

    def _received(self, variant: Variant, run: Run) -> Array:
        """Return what actuators receive in each step of each period, (periods, substeps, nu)."""
        known = np.repeat(run.command, self.substeps, axis=0)
        given = known.copy()
        for actuator in self.hypothesis.robot.actuators:
            at = variant.model.actuator(actuator.name).id
            given[:, at] = received(
                variant.effects, actuator.name, known[:, at], self.hypothesis.step
            )
        return given.reshape(len(run.command), self.substeps, -1)

    def _seen(self, effects: tuple[object, ...], state: Array) -> Array:
        if not any(effect.kind == "sensor" for effect in effects):  # type: ignore[attr-defined]
            return state
        shown = state.copy()
        names = [joint.name for joint in self.hypothesis.robot.joints]
        channels = [f"{name}.position" for name in names] + [f"{name}.velocity" for name in names]
        for at, channel in enumerate(channels):
            shown[..., at] = sensed(effects, channel, state[..., at])  # type: ignore[arg-type]
        return shown


def _per_nudge(difference: Array, nudges: Array) -> Array:
    """Return (p, times, n) differences as slopes, (times, n, p)."""
    scaled = difference / nudges.reshape(-1, *[1] * (difference.ndim - 1))
    return np.moveaxis(scaled, 0, -1)
