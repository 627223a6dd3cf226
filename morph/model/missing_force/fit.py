"""Fitting a simulator and the force that it misses to runs, together and once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.missing_force.corrected import Corrected, within
from morph.model.missing_force.fourier_features import waves_of
from morph.model.missing_force.periods import Periods, PeriodSlopes
from morph.model.missing_force.posterior import Reduced
from morph.model.missing_force.problem import ForceProblem, Iterate, typical_forces
from morph.model.missing_force.settings import ForceSettings, first_settings, settled
from morph.sim.integrator import Integrator

ROUNDS = 3
"""Times that the settings are chosen anew, each about a better trajectory."""

STEPS = 5
"""Most Gauss-Newton steps between."""

HALVINGS = 4
"""Times that a step which makes things worse is halved."""

ENOUGH = 0.5
"""Gain in minus twice the log posterior below which no further step is taken."""


def fit(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    *,
    noise: Array,
    force: bool = True,
    slides: bool = False,
    integrator: Integrator | None = None,
    settings: ForceSettings | None = None,
) -> Corrected:
    """Return a simulator with the force that it misses, both as far as runs show them.

    What is sought together is the hypothesis' point p, the weights w of a force on every joint
    that depends on the state, and the states of every run, so that

        y_t = x_t + noise,  x_{t+1} = F(x_t, u_t; p, force of w) + jump,

    is likeliest under the priors of p and w: Gauss-Newton steps, between which the evidence
    chooses the settings of the force's prior and the size of the jumps. As the states are one
    trajectory each, the error is that of all horizons at once; as p and w are sought in one
    posterior, no datum speaks twice.

    Source: Gamboa Higuera 2015, eqs. 8 and 12; Kennedy and O'Hagan 2001, J. R. Statist. Soc. B
    63(3), eq. 5, for the discrepancy as a Gaussian process beside the figures.

    Args:
        hypothesis: The body, what may be wrong of it and by how much.
        runs: What was recorded.
        noise: Standard deviation of the observations of positions, then velocities, (2 nv,).
        force: Whether a force may be missing at all.
        slides: Whether that force may depend on where slides are.
        integrator: What the simulation steps with; None for its own choice.
        settings: Where their choice begins.

    Raises:
        DiagnosisError: There is no run, runs have different periods or sizes, or the body cannot
            be seen as states that follow one another.
    """
    periods = Periods(hypothesis, _period(runs), integrator)
    _check(hypothesis, periods, runs, noise)
    chosen = settings or first_settings(periods.nv)
    states = tuple(run.state for run in runs)
    kinds = [joint.kind for joint in hypothesis.robot.joints]
    waves = waves_of(kinds, np.concatenate(states), slides=slides)
    believed = Iterate(
        point=hypothesis.start, weight=np.zeros((periods.nv, waves.count)), states=states
    )
    problem = ForceProblem(periods=periods, runs=tuple(runs), noise=noise, waves=waves, unit=None)
    if force:
        problem = replace(problem, unit=typical_forces(problem.slopes(believed, chosen)))
    for _ in range(ROUNDS):
        believed, slopes = _solved(problem, believed, chosen)
        chosen = _settled(problem, slopes, chosen)
        # The weights of waves of other lengths; figures and states stay where slopes were taken.
        weight = _wanted(problem, slopes, chosen).weight
        believed = replace(believed, weight=weight)
    believed, slopes = _solved(problem, believed, chosen)
    parts = problem.reduced(slopes, chosen)
    return Corrected(
        hypothesis=hypothesis,
        integrator=integrator,
        period=periods.period,
        noise=noise,
        waves=problem.looking(chosen),
        unit=problem.unit,
        settings=chosen,
        posterior=problem.posterior(slopes, parts, chosen),
        point=believed.point,
        weight=believed.weight,
        states=believed.states,
        jump=problem.jump(chosen),
    )


def _period(runs: Sequence[Run]) -> float:
    results = sorted({round(run.period, 9) for run in runs})
    if len(results) != 1:
        statement = (
            f"the periods {', '.join(f'{each:g} s' for each in results)}"
            if results
            else "no period"
        )
        raise DiagnosisError(
            f"{len(runs)} runs have {statement}",
            where="runs to correct a simulator from",
            fix="give one run or more, all with one control period",
        )
    return runs[0].period


def _check(hypothesis: Hypothesis, periods: Periods, runs: Sequence[Run], noise: Array) -> None:
    n = 2 * periods.nv
    sizes = sorted({run.state.shape[1] for run in runs})
    if noise.shape != (n,) or not (noise > 0.0).all() or sizes != [n]:
        raise DiagnosisError(
            f"states of the runs have {sizes} numbers, and the noise {noise.shape}",
            where=f"robot {hypothesis.robot.name}",
            fix=f"give a noise above zero for each of the {n} numbers of a state",
        )


def _solved(
    problem: ForceProblem, believed: Iterate, chosen: ForceSettings
) -> tuple[Iterate, list[PeriodSlopes]]:
    """Return what Gauss-Newton steps lead to, and the slopes there."""
    slopes = problem.slopes(believed, chosen)
    cost = problem.cost(believed, slopes, chosen)
    for _ in range(STEPS):
        wanted = _wanted(problem, slopes, chosen)
        for halved in range(HALVINGS):
            tried = believed.towards(wanted, 0.5**halved)
            there = problem.slopes(tried, chosen)
            value = problem.cost(tried, there, chosen)
            if value < cost:
                break
        else:
            break
        gain, believed, slopes, cost = cost - value, tried, there, value
        if gain < ENOUGH:
            break
    return believed, slopes


def _wanted(
    problem: ForceProblem, slopes: Sequence[PeriodSlopes], chosen: ForceSettings
) -> Iterate:
    """Return what is likeliest if the slopes hold everywhere."""
    parts = problem.reduced(slopes, chosen)
    result = problem.posterior(slopes, parts, chosen)
    size = len(slopes[0].point)
    point = within(problem.periods.hypothesis, result.mean[:size])
    shape = (problem.periods.nv, problem.waves.count)
    weight = np.zeros(shape) if problem.unit is None else result.mean[size:].reshape(shape)
    states = []
    for each, part in zip(slopes, parts, strict=True):
        force = (problem.features(each, chosen) * weight).sum(axis=-1)
        off = part.states(np.concatenate([point, force.ravel()]))
        states.append(each.state + off.reshape(each.state.shape))
    return Iterate(point=point, weight=weight, states=tuple(states))


def _settled(
    problem: ForceProblem, slopes: Sequence[PeriodSlopes], chosen: ForceSettings
) -> ForceSettings:
    """Return the settings that the evidence prefers, about the slopes as they are."""
    nv = problem.periods.nv
    kept: dict[bytes, list[Reduced]] = {}

    def evidence(tried: ForceSettings) -> float:
        key = tried.jump.tobytes()
        if key not in kept:
            kept[key] = problem.reduced(slopes, tried)
        return problem.posterior(slopes, kept[key], tried).log_evidence

    free = range(2 * nv, 3 * nv) if problem.unit is None else range(3 * nv + 2)
    return settled(chosen, evidence, tuple(free))
