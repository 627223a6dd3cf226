"""Control periods of a body at many points of a hypothesis, under forces besides, in one batch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from morph.arrays import Array
from morph.errors import DiagnosisError, SimulationFailed
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.missing_force.fourier_features import FourierFeatures
from morph.physics.fluid.settle import batches
from morph.sim.integrator import INTEGRATORS, Integrator, best_integrator
from morph.sim.rollout import quiet

MOST_KEPT = 6
"""Batches of different sizes that are kept."""

WILD = 1e6
"""Position or velocity, in its unit, from which a row is no motion any more."""

NUDGE = 1e-5
"""Difference of a state, rad or m or per s, of which a slope is made."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PeriodSlopes:
    """How the control periods of one run go, about the states that are believed of it."""

    state: Array
    """x, shape (periods + 1, n)."""
    missed: Array
    """x_{t+1} - F(x_t, u_t), shape (periods, n)."""
    of_state: Array
    """dF/dx, shape (periods, n, n); how the force depends on the state included."""
    of_point: Array
    """dF/dp, p being the point of the hypothesis, shape (periods, n, size)."""
    of_force: Array
    """dF/df, f being the mean force of the period, shape (periods, n, joints)."""
    inside: Array
    """States through each period, shape (periods, steps, n)."""
    point: Array
    """p."""
    force: Array
    """f, shape (periods, joints)."""


class Periods:
    """A body of hinges and slides whose commands are held through control periods.

    Args:
        hypothesis: The body and what may be wrong of it.
        period: Length of a control period, s: a multiple of the hypothesis' step.
        integrator: What it steps with; None for the better of the two.

    Raises:
        DiagnosisError: The body has other joints, the period does not fit, or an effect cannot be
            held by MuJoCo alone.
    """

    def __init__(
        self, hypothesis: Hypothesis, period: float, integrator: Integrator | None = None
    ) -> None:
        """Check that the body can be seen as states that follow one another."""
        where = f"robot {hypothesis.robot.name}"
        if any(joint.kind not in {"hinge", "slide"} for joint in hypothesis.robot.joints):
            raise DiagnosisError(
                "a joint of it is neither a hinge nor a slide",
                where=where,
                fix="weld that joint in the description if the link does not move by it",
            )
        steps = round(period / hypothesis.step)
        if steps < 1 or abs(steps * hypothesis.step - period) > 1e-6 * period:
            raise DiagnosisError(
                f"a period of {period:g} s is no multiple of a step of {hypothesis.step:g} s",
                where=where,
                fix="take the period of the runs, and a step that divides it",
            )
        outside = [e.label for e in hypothesis.effects if e.outside]
        model: Any = hypothesis.at(hypothesis.start).model
        if outside or model.na or not batches(model):
            raise DiagnosisError(
                f"{', '.join(outside) or 'a fluid or an actuator'} acts outside of MuJoCo's state",
                where=where,
                fix="leave it out here, and let the missing force stand for it",
            )
        self.hypothesis, self.period, self.steps = hypothesis, period, steps
        self.integrator = INTEGRATORS[integrator or best_integrator(model)]
        self.nv = int(model.nv)
        self._kept: dict[int, Batch] = {}

    def models(self, points: Sequence[Array]) -> list[Any]:
        """Return the compiled models at points of the hypothesis."""
        results = [self.hypothesis.at(point).model for point in points]
        for model in results:
            model.opt.integrator = self.integrator
        return results

    def within(
        self, models: Sequence[Any], state: Array, command: Array, force: Array | Callable[..., Any]
    ) -> Array:
        """Return the states after each step of one period, shape (rows, steps, n).

        Args:
            models: One for each row, or one for all.
            state: Where each row begins, shape (rows, n).
            command: What it is told, shape (rows, nu).
            force: On each joint, (rows, joints), or a function from states to it.

        Raises:
            SimulationFailed: MuJoCo refuses to step.
        """
        rows, nv = len(state), self.nv
        batch = self._batch(models[0], rows)
        batch.set_models(models[0] if len(models) == 1 else list(models))
        batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        fine = np.asarray((np.abs(np.nan_to_num(state, nan=np.inf)) < WILD).all(axis=1))[:, None]
        q, v = batch.bind("qpos"), batch.bind("qvel")
        now = np.where(fine, state, 0.0)
        q[:], v[:] = now[:, :nv], now[:, nv:]
        batch.bind("ctrl")[:] = command
        applied = batch.bind("qfrc_applied")
        result = np.empty((rows, self.steps, 2 * nv))
        with quiet():
            for at in range(self.steps):
                applied[:] = force(now) if callable(force) else force
                try:
                    batch.step()
                except SimulationError as error:
                    raise SimulationFailed(
                        f"MuJoCo stopped: {error}",
                        where=f"{rows} control periods of {self.hypothesis.robot.name}",
                        fix="check the robot's masses and inertias, or take a smaller step",
                    ) from error
                result[:, at, :nv], result[:, at, nv:] = q, v
                now = np.clip(np.nan_to_num(result[:, at]), -WILD, WILD)
        return np.where(fine[:, None], result, np.nan)

    def _batch(self, model: Any, rows: int) -> Batch:
        if rows not in self._kept:
            if len(self._kept) >= MOST_KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[rows] = Batch(model, rows, 1)
        return self._kept[rows]

    def slopes(
        self, run: Run, state: Array, point: Array, waves: FourierFeatures | None, weight: Array
    ) -> PeriodSlopes:
        """Return how a run's periods go from the states that are believed of it.

        Args:
            run: The run.
            state: What is believed, shape (periods + 1, n).
            point: The hypothesis' point.
            waves: What the missing force looks at; None for no force.
            weight: Its weights, shape (joints, features).
        """
        begin, nv, size = state[:-1], self.nv, len(point)
        n, count = 2 * nv, len(begin)
        nudge = self.hypothesis.nudge(point)
        models = self.models([point, *(point + np.diag(nudge))])
        law = None if waves is None else (lambda x: (waves.of(x) * weight).sum(axis=-1))
        none = np.zeros((count, nv))
        through = self.within(models[:1], begin, run.command, none if law is None else law)
        # Where a step begins is where its force is found.
        inside = np.concatenate([begin[:, None], through[:, :-1]], axis=1)
        force = none if law is None else law(inside).mean(axis=1)
        push = 1e-3 * (1.0 + np.abs(force).max(axis=0))
        kinds = 1 + n + size + nv
        many = np.repeat(begin[:, None], kinds, axis=1)
        many[:, 1 : 1 + n] += NUDGE * np.eye(n)
        pushed = np.repeat(force[:, None], kinds, axis=1)
        pushed[:, 1 + n + size :] += np.diag(push)
        which = [0] * (1 + n) + list(range(1, size + 1)) + [0] * nv
        end = self.within(
            [models[at] for at in which] * count,
            many.reshape(-1, n),
            np.repeat(run.command, kinds, axis=0),
            pushed.reshape(-1, nv),
        )[:, -1].reshape(count, kinds, n)
        change = np.swapaxes(end[:, 1:] - end[:, :1], 1, 2)
        of_force = change[:, :, n + size :] / push
        of_state = change[:, :, :n] / NUDGE
        if law is not None:
            of_state = of_state + of_force @ _steepness(law, inside)
        return PeriodSlopes(
            state=state,
            missed=state[1:] - end[:, 0],
            of_state=of_state,
            of_point=change[:, :, n : n + size] / nudge,
            of_force=of_force,
            inside=inside,
            point=point,
            force=force,
        )


ROUGH = 0.02
"""Difference of a state over which the slope of a force is taken; it may be rough below."""


def _steepness(law: Callable[[Array], Array], inside: Array) -> Array:
    """Return the slope of the mean force in the state, shape (periods, joints, n)."""
    move = ROUGH * np.eye(inside.shape[-1])
    ahead, behind = (law(inside[:, :, None] + sign * move) for sign in (1.0, -1.0))
    return np.asarray(np.swapaxes((ahead - behind).mean(axis=1), 1, 2) / (2.0 * ROUGH))
