"""What the gate is compared with: independent noise, commands shuffled, a plain process."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.gate.measures import Judged, is_good
from experiments.gate.targets import Case, ahead, hypothesis, model, noise, nominal
from morph.arrays import Array
from morph.model.gp.fit import fit
from morph.model.kwik.certify import EPSILONS, judge, verdict_of
from morph.model.kwik.innovations import Account
from morph.model.kwik.transition_evidence import ROUGH, visit
from morph.model.latent.transition_model import Transit

DELTA, SHARE = 0.05, 0.05
"""Those of the gate."""

DRAWS = 400
"""Draws from the plain process."""


def judged(case: Case, answer: str, probability: float, transitions: Array) -> Judged:
    """Return a control's answer on the whole run."""
    fine = EPSILONS * noise()
    return Judged(
        seed=case.seed,
        family=case.family,
        label=case.label,
        moments=(len(case.error),),
        answers=(answer,),
        sure=(probability,),
        truth=(is_good(case.error, fine, SHARE),),
        inside=np.asarray((np.abs(case.error) < fine).all(axis=1)),
        transitions=transitions,
    )


def independent(case: Case) -> Judged:
    """Return the gate's answer if every transition's noise were independent of its neighbours'."""
    wanted, fine = nominal(), EPSILONS * noise()
    transit = Transit(hypothesis=hypothesis(), period=wanted.period, integrator=model().integrator)
    seen = visit(transit, [case.run], noise(), fine)
    slopes = transit.slopes(hypothesis().start, case.run, case.run.state)
    R, Q = np.diag(noise() ** 2), np.diag((ROUGH * noise()) ** 2)
    A = slopes.state
    lower = np.linalg.cholesky(A @ R @ A.swapaxes(1, 2) + R + Q)
    missed = case.run.state[1:] - slopes.value
    apart = Account(
        surprise=np.linalg.solve(lower, missed[..., None])[..., 0],
        slope=np.linalg.solve(lower, seen.error * fine[:, None]),
    )
    rng = np.random.default_rng(case.seed)
    said = verdict_of(
        replace(seen, account=apart), len(seen), hypothesis(), fine, DELTA, SHARE, rng
    )
    return judged(case, said.verdict, said.probability, said.transitions)


def shuffled(case: Case) -> Judged:
    """Return the gate's answer if the commands are recorded in another order than they ran."""
    rng = np.random.default_rng(case.seed)
    run = replace(case.run, command=rng.permutation(case.run.command))
    said = judge(hypothesis(), [run], noise(), integrator=model().integrator, rng=rng)
    return judged(case, said.verdict, said.probability, said.transitions)


def plain(case: Case) -> Judged:
    """Return the answer of a Gaussian process with the simulator as its mean, and no more.

    What the target's next observation is more than the simulator's prediction from this one is
    fitted by state and command, as if noise were independent and only in the outputs.
    """
    fine, state = EPSILONS * noise(), case.run.state
    missed = state[1:] - ahead(model(), state[:-1], case.run.command, case.run.period)
    inputs = np.concatenate([state[:-1], case.run.command], axis=1)
    half = state.shape[1] // 2
    process = fit(inputs, missed[:, half:], steps=30)
    mean, variance = process.predict(inputs)
    rng = np.random.default_rng(case.seed)
    drawn = mean + np.sqrt(np.maximum(variance, 0.0)) * rng.standard_normal((DRAWS, *mean.shape))
    beyond = (np.abs(drawn) >= fine[half:]).any(axis=2)
    most = int(SHARE * len(mean) + 1e-9)
    probability = float(np.mean(beyond.sum(axis=1) <= most))
    answer = (
        "good"
        if probability >= 1.0 - DELTA
        else "not good"
        if probability <= DELTA
        else "cannot say"
    )
    return judged(case, answer, probability, 1.0 - beyond.mean(axis=0))


CONTROLS = {
    "noise as if independent": independent,
    "commands shuffled in time": shuffled,
    "plain Gaussian process": plain,
}
"""Every control by its name."""
