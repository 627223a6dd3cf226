"""A simulator with the force that it misses, and what it foresees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.gaussian.information import Information
from morph.model.hypothesis import Hypothesis
from morph.model.latent.unknowns import with_knobs
from morph.model.missing_force.force import MissingForce
from morph.model.missing_force.fourier_features import FourierFeatures
from morph.model.missing_force.periods import Periods
from morph.model.missing_force.settings import ForceSettings
from morph.physics.effect import Effect
from morph.sim.integrator import Integrator
from morph.sim.simulator import Simulator

MOST = 30.0
"""Greatest factor by which a figure of the description may be found to be off."""

DRAWS = 64
"""Bodies with forces, drawn from the posterior, by which runs are foreseen."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictedRuns:
    """What runs will look like, as draws: of each run, so many possible ones."""

    states: Array
    """True states, shape (draws, runs, periods + 1, n); NaN where a draw became unstable."""
    noise: Array
    """Standard deviation of an observation of them, shape (n,)."""

    @property
    def mean(self) -> Array:
        """Mean of the states, shape (runs, periods + 1, n)."""
        return np.asarray(np.nanmean(self.states, axis=0))

    @property
    def variance(self) -> Array:
        """Variance of the states, without the noise of observing them; same shape."""
        return np.asarray(np.nanvar(self.states, axis=0))

    def observed(self, rng: np.random.Generator) -> Array:
        """Return the draws as they would be observed, same shape as `states`."""
        return self.states + self.noise * rng.normal(size=self.states.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class Corrected:
    """A simulator, its figures and a missing force, as far as runs showed them."""

    hypothesis: Hypothesis
    """The body, and what might have been wrong of it."""
    integrator: Integrator | None
    """What it steps with; None for its own choice."""
    period: float
    """Length of a control period, s."""
    noise: Array
    """Standard deviation of the observations, shape (n,)."""
    waves: FourierFeatures
    """What the force looks at."""
    unit: Array | None
    """Typical forces of the motion, shape (joints,); None if no force was sought."""
    settings: ForceSettings
    """Settings that the evidence chose."""
    posterior: Information
    """Of the point and the weights together."""
    point: Array
    """The likeliest point of the hypothesis."""
    weight: Array
    """The likeliest weights of the force, shape (joints, features)."""
    states: tuple[Array, ...]
    """The likeliest states of each run, (periods + 1, n)."""
    jump: Array
    """Variance of what stays unexplained in a period, shape (n,)."""
    scale: float = 1.0
    """What calibration multiplied the standard deviations by."""

    @property
    def robot(self) -> Robot:
        """The body with its figures corrected."""
        knobs = self.hypothesis.knobs
        return with_knobs(self.hypothesis.robot, knobs, self.point[: len(knobs)])

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The hypothesis' effects as they were found, and the missing force."""
        result = self.hypothesis.effects_at(self.point)
        return result if self.unit is None else (*result, self.missing)

    @property
    def missing(self) -> MissingForce:
        """The likeliest missing force."""
        joints = tuple(joint.name for joint in self.hypothesis.robot.joints)
        return MissingForce(joints=joints, waves=self.waves, weight=self.weight)

    @property
    def simulator(self) -> Simulator:
        """The likeliest simulator, to search in."""
        return Simulator(
            self.robot, self.effects, step=self.hypothesis.step, integrator=self.integrator
        )

    @property
    def factors(self) -> dict[str, float]:
        """By what each figure of the description was multiplied."""
        names = self.hypothesis.names[: len(self.hypothesis.knobs)]
        return {name: float(np.exp(x)) for name, x in zip(names, self.point, strict=False)}

    def scaled(self, scale: float) -> Corrected:
        """Return the same with standard deviations that many times as large as now."""
        return replace(self, scale=self.scale * scale)

    def foresee(
        self,
        start: Array,
        command: Array,
        rng: np.random.Generator,
        *,
        draws: int = DRAWS,
        known: bool = False,
    ) -> PredictedRuns:
        """Return what many runs will look like under commands that nothing corrects.

        Bodies and forces are drawn from the posterior, and each is one body throughout all runs
        and periods: what is not known of it is wrong in the same way from one period to the next.

        Args:
            start: Where each run begins, as observed, shape (runs, n).
            command: Shape (runs, periods, nu).
            rng: Chance.
            draws: How many of each run.
            known: Whether the starts are known without noise.

        Raises:
            DiagnosisError: Shapes do not fit.
        """
        periods = Periods(self.hypothesis, self.period, self.integrator)
        if start.ndim != 2 or start.shape[1] != 2 * periods.nv or len(command) != len(start):
            raise DiagnosisError(
                f"starts have the shape {start.shape} and commands {command.shape}",
                where=f"a forecast for {self.hypothesis.robot.name}",
                fix="give a state and a row of commands for each run",
            )
        drawn = self.posterior.drawn(draws, rng, self.scale)
        # The posterior's mean is that of its last linearisation: draws spread about what was kept.
        size = len(self.point)
        points = within(self.hypothesis, drawn[:, :size] + self.point - self.posterior.mean[:size])
        runs, count = command.shape[:2]
        rows = draws * runs
        models = [model for model in periods.models(list(points)) for _ in range(runs)]
        law = self._law(drawn[:, size:], runs)
        now = np.tile(start, (draws, 1))
        if not known:
            now = now + self.noise * rng.normal(size=now.shape)
        given = np.tile(command, (draws, 1, 1))
        result = np.empty((rows, count + 1, now.shape[1]))
        result[:, 0] = now
        spread = self.scale * np.sqrt(self.jump)
        for at in range(count):
            now = periods.within(models, now, given[:, at], law)[:, -1]
            now = now + spread * rng.normal(size=now.shape)
            result[:, at + 1] = now
        shape = (draws, runs, count + 1, now.shape[1])
        return PredictedRuns(states=result.reshape(shape), noise=self.noise)

    def _law(self, drawn: Array, runs: int) -> Array | Callable[[Array], Array]:
        """Return the force of every row's own draw as a function of the rows' states."""
        if self.unit is None:
            return np.zeros((len(drawn) * runs, self.waves.joints))
        shape = (len(drawn), *self.weight.shape)
        mean = self.posterior.mean[len(self.point) :]
        weight = (drawn - mean).reshape(shape) + self.weight

        def law(state: Array) -> Array:
            features = self.waves.of(state).reshape(len(weight), runs, *shape[1:])
            force = np.einsum("drjc,djc->drj", features, weight)
            return np.asarray(force.reshape(len(state), -1))

        return law


def within(hypothesis: Hypothesis, point: Array) -> Array:
    """Return points (..., size) brought to where a simulation can be made of them.

    The figures' own priors are soft: only what no body is, is cut off.
    """
    low, high = hypothesis.low.copy(), hypothesis.high.copy()
    knobs = len(hypothesis.knobs)
    low[:knobs], high[:knobs] = -np.log(MOST), np.log(MOST)
    return np.asarray(np.clip(point, low, high))
