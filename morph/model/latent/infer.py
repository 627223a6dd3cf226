"""States and parameters of a body from a run or several, and how probable they make the runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError, EffectError, SimulationFailed
from morph.model.fit import PointBounds
from morph.model.gaussian.states import ReducedEquations, Trust
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.latent.transition_model import Transit, TransitionSlopes
from morph.model.latent.unknowns import MOST, with_knobs
from morph.physics.effect import Effect
from morph.sim.integrator import Integrator

UNSAID = (1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
"""Shares of a typical change of speed in one period that a model may leave out."""

SHARES = (1.0, 0.5, 0.2, 0.05)
"""Shares of a Gauss-Newton step that are tried."""

ENOUGH = 0.02
"""Gain in log evidence at which steps end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Inferred:
    """A hypothesis with its parameters and the states of its runs, as the runs tell.

    The parameters are normal about `point` with `covariance`, and the states' best change with
    them is linear (Laplace's approximation).
    """

    transit: Transit
    """The hypothesis and its clock."""
    runs: tuple[Run, ...]
    """What it was inferred from."""
    point: Array
    """Most probable parameters, shape (p,); the order is `transit.hypothesis.names`."""
    covariance: Array
    """Of the parameters, shape (p, p)."""
    states: tuple[Array, ...]
    """Most probable states of each run, shape (periods + 1, n)."""
    evidence: float
    """log p(runs | hypothesis)."""
    unsaid: float
    """What the model leaves out, as a share of a typical change of speed in one period."""
    trust: Trust
    """How observations and transitions were weighed."""
    slopes: tuple[TransitionSlopes, ...]
    """About these states and this point, one for each run."""

    @property
    def hypothesis(self) -> Hypothesis:
        """What was inferred."""
        return self.transit.hypothesis

    @property
    def names(self) -> tuple[str, ...]:
        """What each entry of the point is called."""
        return self.hypothesis.names

    @cached_property
    def bands(self) -> tuple[ReducedEquations, ...]:
        """The normal equations of each run about its states."""
        return tuple(
            slopes.band(state, run.state, self.trust)
            for slopes, state, run in zip(self.slopes, self.states, self.runs, strict=True)
        )

    @cached_property
    def robot(self) -> Robot:
        """The robot with its knobs turned to the most probable values."""
        knobs = self.hypothesis.knobs
        return with_knobs(self.hypothesis.robot, knobs, self.point[: len(knobs)])

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects with their most probable parameters."""
        return self.hypothesis.effects_at(self.point)


def infer(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    noise: Array,
    *,
    integrator: Integrator = "implicitfast",
    begin: Inferred | None = None,
    point: Array | None = None,
    steps: int = 20,
) -> Inferred:
    """Return the most probable parameters and states, with the evidence for the hypothesis.

    States and parameters are found together by Gauss-Newton steps, so that noise in a state,
    which enters two transitions, counts once, and a motion that no parameter reaches is still
    followed. How much the model leaves out in a period is chosen by the evidence at each step.

    Args:
        hypothesis: The body; the width of each knob is its `fraction`.
        runs: What was observed, all on one clock.
        noise: Standard deviation of each observation, positions then velocities, shape (n,).
        integrator: What the simulation steps with.
        begin: The same runs under a hypothesis that lacks nothing but the last entries: a start.
        point: Parameters to begin at; default the hypothesis' own, or those of `begin`.
        steps: Most Gauss-Newton steps.

    Raises:
        DiagnosisError: There is no run, runs differ in clock, or a transition cannot be made.
    """
    transit = Transit(
        hypothesis=hypothesis, period=_period(runs, hypothesis), integrator=integrator
    )
    search = _Search(transit, tuple(runs), np.asarray(noise, dtype=float))
    start = hypothesis.start.copy() if point is None else np.array(point, dtype=float)
    if begin is not None and point is None:
        start[: min(len(begin.point), len(start))] = begin.point[: len(start)]
    states = [run.state for run in runs] if begin is None else list(begin.states)
    return search.best(start, states, steps, 0.5 if begin is None else begin.unsaid)


def _period(runs: Sequence[Run], hypothesis: Hypothesis) -> float:
    periods = {run.period for run in runs}
    if len(periods) != 1:
        raise DiagnosisError(
            f"there are {len(runs)} runs, with control periods of {sorted(periods)} s",
            where=f"robot {hypothesis.robot.name}",
            fix="give one run or more, all with one control period",
        )
    return periods.pop()


class _Search:
    def __init__(self, transit: Transit, runs: tuple[Run, ...], noise: Array) -> None:
        self.transit, self.runs = transit, runs
        hypothesis = transit.hypothesis
        known = len(hypothesis.knobs)
        most = math.log(MOST)
        self.room = PointBounds(
            low=np.concatenate([np.full(known, -most), hypothesis.low[known:]]),
            high=np.concatenate([np.full(known, most), hypothesis.high[known:]]),
            trust=hypothesis.trust,
            centre=np.concatenate([np.zeros(known), hypothesis.start[known:]]),
        )
        self.seen = 1.0 / noise**2
        half = len(noise) // 2
        change = np.sqrt(
            np.mean([np.mean(np.diff(r.velocity, axis=0) ** 2, axis=0) for r in runs], axis=0)
        )
        change = np.maximum(change, 2.0 * noise[half:])
        self.typical = np.concatenate([0.5 * transit.period * change, change])

    def trust(self, unsaid: float) -> Trust:
        """Return how errors are weighed when a model leaves out so much."""
        return Trust(seen=self.seen, moved=1.0 / (unsaid * self.typical) ** 2)

    def best(self, point: Array, states: list[Array], steps: int, unsaid: float) -> Inferred:
        """Return where Gauss-Newton steps end."""
        slopes = self._slopes(point, states)
        for _ in range(steps):
            last, unsaid = unsaid, self._unsaid(slopes, states, point, unsaid)
            # While less and less is left out, small steps are no sign of an end.
            settled = unsaid >= last
            bands = self._bands(slopes, states, unsaid)
            change, foreseen = self._change(bands, point)
            before = self._cost(bands, point)
            moved = [each.states(change) for each in bands]
            for share in SHARES:
                tried = np.clip(point + share * change, self.room.low, self.room.high)
                nearby = [
                    state + share * each.reshape(state.shape)
                    for state, each in zip(states, moved, strict=True)
                ]
                cost = self._costs(tried, nearby, unsaid)
                if cost < before:
                    break
            else:
                if settled:
                    break
                continue
            point, states = tried, nearby
            slopes = self._slopes(point, states)
            if settled and (foreseen < ENOUGH or before - cost < ENOUGH):
                break
        return self._concluded(slopes, states, point, unsaid)

    def _concluded(
        self, slopes: list[TransitionSlopes], states: list[Array], point: Array, unsaid: float
    ) -> Inferred:
        unsaid = self._unsaid(slopes, states, point, unsaid)
        bands = self._bands(slopes, states, unsaid)
        precision = sum(each.hessian for each in bands) + np.diag(self.room.trust)
        return Inferred(
            transit=self.transit,
            runs=self.runs,
            point=point,
            covariance=np.asarray(np.linalg.inv(precision), dtype=np.float64),
            states=tuple(states),
            evidence=self._evidence(bands, point, unsaid),
            unsaid=unsaid,
            trust=self.trust(unsaid),
            slopes=tuple(slopes),
        )

    def _slopes(self, point: Array, states: list[Array]) -> list[TransitionSlopes]:
        return [
            self.transit.slopes(point, run, state)
            for run, state in zip(self.runs, states, strict=True)
        ]

    def _bands(
        self, slopes: list[TransitionSlopes], states: list[Array], unsaid: float
    ) -> list[ReducedEquations]:
        trust = self.trust(unsaid)
        return [
            slope.band(state, run.state, trust)
            for slope, state, run in zip(slopes, states, self.runs, strict=True)
        ]

    def _unsaid(
        self, slopes: list[TransitionSlopes], states: list[Array], point: Array, now: float
    ) -> float:
        """Return the most probable share left out; it falls at most to a third in one step."""
        tried = [share for share in UNSAID if share >= 0.3 * now]
        results = [
            self._evidence(self._bands(slopes, states, share), point, share) for share in tried
        ]
        return tried[int(np.argmax(results))]

    def _change(self, bands: list[ReducedEquations], point: Array) -> tuple[Array, float]:
        """Return the parameters' best change within bounds, and what it and the states gain."""
        hessian, slope = self._total(bands)
        change = self.room.best_change(hessian, slope, point)
        pull = slope - self.room.trust * (point - self.room.centre)
        whole = hessian + np.diag(self.room.trust)
        gain = float(pull @ change - 0.5 * change @ whole @ change)
        return change, gain + sum(each.reach for each in bands)

    def _total(self, bands: list[ReducedEquations]) -> tuple[Array, Array]:
        return (
            np.sum([each.hessian for each in bands], axis=0),
            np.sum([each.slope for each in bands], axis=0),
        )

    def _cost(self, bands: list[ReducedEquations], point: Array) -> float:
        return sum(each.cost for each in bands) + 0.5 * self.room.price(point)

    def _costs(self, point: Array, states: list[Array], unsaid: float) -> float:
        """Return half the sum of squares at a point, by simulating every transition."""
        trust, total = self.trust(unsaid), 0.5 * self.room.price(point)
        for run, state in zip(self.runs, states, strict=True):
            missed = run.state - self.transit.seen(point, state)
            try:
                off = state[1:] - self.transit.ahead(point, run, state)
            except (EffectError, SimulationFailed):
                # No body could be so: an added mass that is not positive, say.
                return math.inf
            total += 0.5 * float((trust.seen * missed**2).sum() + (trust.moved * off**2).sum())
        return total if math.isfinite(total) else math.inf

    def _evidence(self, bands: list[ReducedEquations], point: Array, unsaid: float) -> float:
        """Return log p(runs | hypothesis), exact where everything is linear.

        Source: MacKay 1992, Neural Computation 4(3), Bayesian interpolation, eq. 2.6 in logs.
        """
        trust, periods = self.trust(unsaid), sum(len(run.command) for run in self.runs)
        hessian, _ = self._total(bands)
        _, gain = self._change(bands, point)
        least = self._cost(bands, point) - gain
        whole = hessian + np.diag(self.room.trust)
        occam = np.linalg.slogdet(whole)[1] - np.log(self.room.trust).sum()
        states = sum(each.log_determinant for each in bands)
        times = periods + len(self.runs)
        log = times * np.log(trust.seen).sum() + periods * np.log(trust.moved).sum()
        # One state's worth of numbers more is integrated over than errors are weighed.
        spare = (periods * len(self.seen)) * math.log(2.0 * math.pi)
        return float(-least + 0.5 * (log - states - occam - spare))
