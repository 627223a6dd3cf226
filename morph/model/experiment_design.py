"""Experiment design: which runs to record next for the largest information gain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from morph.arrays import Array
from morph.errors import DiagnosisError
from morph.model.latent.run import Run
from morph.model.missing_force.corrected import Corrected
from morph.model.missing_force.periods import Periods
from morph.model.missing_force.problem import ForceProblem, Iterate


@dataclass(frozen=True, kw_only=True, eq=False)
class CandidateRun:
    """A run that might be recorded."""

    start: Array
    """State from which it begins, shape (n,)."""
    command: Array
    """What is told, shape (periods, nu); of a policy, what it tells in simulation."""
    explores: bool = True
    """Whether it is for exploring; else it is a run of the policy that is in use."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProposedRun:
    """A run to record, and why."""

    index: int
    """Which of the candidates."""
    gain: float
    """What it is expected to tell beside those that were chosen before, nats."""


def information(corrected: Corrected, candidates: Sequence[CandidateRun]) -> list[Array]:
    """Return what each run would add to the precision of figures and weights, (k, k) each.

    Each run is simulated as the model expects it, and its slopes say how it answers to figures
    and weights; what will be observed does not matter to how precise it is.

    Args:
        corrected: The model.
        candidates: The runs.
    """
    periods = Periods(corrected.hypothesis, corrected.period, corrected.integrator)
    results = []
    for each in candidates:
        states = _expected(periods, corrected, each)
        run = Run(
            position=states[:, : periods.nv],
            velocity=states[:, periods.nv :],
            command=each.command,
            period=corrected.period,
        )
        problem = ForceProblem(
            periods=periods,
            runs=(run,),
            noise=corrected.noise,
            waves=corrected.waves,
            unit=corrected.unit,
        )
        belief = Iterate(point=corrected.point, weight=corrected.weight, states=(states,))
        slopes = problem.slopes(belief, corrected.settings)
        parts = problem.reduced(slopes, corrected.settings)
        results.append(problem.told(slopes, parts, corrected.settings)[0].H)
    return results


def chosen(
    corrected: Corrected, candidates: Sequence[CandidateRun], count: int
) -> list[ProposedRun]:
    """Return the runs to record next, in order: every other one explores.

    A model that is right where its data are serves a policy only where that policy goes, and the
    policy goes where the model errs in its favour: so half of the runs are of the policy in use.
    Among each half that run is taken which tells the most beside those taken before: its expected
    gain of information is 1/2 log det(1 + inv(P) D) nats, P being the precision so far and D what
    the run adds. If one half has no more candidates, the other fills its place.

    Source: Ross and Bagnell 2012, ICML, algorithm 1 (the mixture of the two distributions);
    Lindley 1956, Annals of Mathematical Statistics 27(4) (the gain), for a linear model as in
    Chaloner and Verdinelli 1995, Statistical Science 10(3), eq. 4.

    Args:
        corrected: The model.
        candidates: Runs that might be recorded.
        count: How many to choose.

    Raises:
        DiagnosisError: There are fewer candidates than are to be chosen.
    """
    if not 1 <= count <= len(candidates):
        raise DiagnosisError(
            f"{count} of {len(candidates)} runs are to be chosen",
            where="the choice of the next runs",
            fix="give one candidate or more for each run that is wanted",
        )
    added = information(corrected, candidates)
    precision = corrected.posterior.H
    left = list(range(len(candidates)))
    results: list[ProposedRun] = []
    for number in range(count):
        wanted = [at for at in left if candidates[at].explores == (number % 2 == 0)] or left
        L = np.asarray(np.linalg.cholesky(precision), dtype=np.float64)
        gains = {at: _gain(L, added[at]) for at in wanted}
        best = max(wanted, key=lambda at: gains[at])
        results.append(ProposedRun(index=best, gain=gains[best]))
        precision = precision + added[best]
        left.remove(best)
    return results


def _gain(factor: Array, added: Array) -> float:
    half = solve_triangular(factor, added, lower=True)
    both = solve_triangular(factor, half.T, lower=True)
    # Rounding leaves eigenvalues that should be 0 a little below it.
    values = np.linalg.eigvalsh(0.5 * (both + both.T))
    return 0.5 * float(np.log1p(np.maximum(values, 0.0)).sum())


def _expected(periods: Periods, corrected: Corrected, each: CandidateRun) -> Array:
    """Return the states that the model expects, shape (periods + 1, n)."""
    models = periods.models([corrected.point])
    force = np.zeros((1, periods.nv)) if corrected.unit is None else corrected.missing.force
    states = [np.asarray(each.start, dtype=float)]
    for command in each.command:
        states.append(periods.within(models, states[-1][None], command[None], force)[0, -1])
    return np.array(states)
