"""One case after the other: what the gate answers at every moment, and what a cost is foretold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.gate.controls import SHARE
from experiments.gate.measures import Judged, is_good
from experiments.gate.targets import Case, hypothesis, model, noise, nominal
from morph.arrays import JSON
from morph.model.kwik.certify import EPSILONS, watch
from morph.model.kwik.cost import WITHIN, foretell
from morph.policy.policy import Policy
from morph.search.evaluate import evaluate
from morph.search.search import Problem
from morph.search.searches import search

EVERY = 3
"""Transitions between the moments at which the gate is asked."""

JUDGES = 64
"""Noisy runs by which the true cost on a target is known."""

APART = 7_000_001
"""Added to a seed for the chance of those, which no gate draws from."""


def policies(seeds: Sequence[int]) -> list[Policy]:
    """Return policies that swing the model up, planned from these seeds."""
    problem = Problem(task=nominal(), simulator=model())
    return [search("ddp")().run(problem, seed=seed).policy for seed in seeds]


def in_model(policy: Policy) -> float:
    """Return what a policy costs in the model."""
    rng = np.random.default_rng(APART)
    return evaluate(nominal(), policy, model(), rng=rng, rows=4 * JUDGES).mean


def watched(case: Case) -> Judged:
    """Return what the gate answers at every moment of a run."""
    fine, periods = EPSILONS * noise(), len(case.error)
    moments = (*range(EVERY, periods, EVERY), periods)
    said = watch(
        hypothesis(),
        [case.run],
        noise(),
        moments,
        integrator=model().integrator,
        rng=np.random.default_rng(case.seed),
    )
    return Judged(
        seed=case.seed,
        family=case.family,
        label=case.label,
        moments=moments,
        answers=tuple(each.verdict for each in said),
        sure=tuple(each.probability for each in said),
        truth=tuple(is_good(case.error[:count], fine, SHARE) for count in moments),
        inside=np.asarray((np.abs(case.error) < fine).all(axis=1)),
        transitions=said[-1].transitions,
    )


def cost(case: Case, tried: Sequence[Policy], gate: Judged, here: float) -> JSON:
    """Return what the policy is foretold to cost on a target, and what it costs there.

    Args:
        case: The target.
        tried: All policies.
        gate: What the gate says of it.
        here: What the policy costs in the model.
    """
    policy = tried[case.policy]
    said = foretell(
        hypothesis(), [case.run], nominal(), policy, rng=np.random.default_rng(case.seed)
    )
    rng = np.random.default_rng(case.seed + APART)
    true = evaluate(case.task, policy, case.task.simulator(case.effects), rng=rng, rows=JUDGES)
    return {
        "seed": case.seed,
        "family": case.family,
        "label": case.label,
        "gate": gate.answers[-1],
        "good": gate.truth[-1],
        "answer": said.verdict,
        "probability": said.probability,
        "model": here,
        "target": true.mean,
        "foretold": float(np.median(said.targets)),
        "within": bool(abs(true.mean - here) <= WITHIN * here),
    }
