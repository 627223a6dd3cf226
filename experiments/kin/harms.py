"""One target of the study of harm: what was foreseen of each policy, and what it then did."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.kin.bodies import kin
from experiments.kin.carried import agreement, wanted_of
from experiments.kin.pairs import pairs
from experiments.kin.seen import belief, seen, trial
from morph.alignment.belief import Belief
from morph.alignment.guard import PredictedScores, TrialTask, foreseen
from morph.alignment.samples import Transitions
from morph.arrays import JSON, Array
from morph.policy_transfer.body import Law, linear_law, still_law

ROWS = 16
"""Runs of the target by which a policy is measured; they begin alike for all policies."""


def harms(seed: int, number: int) -> JSON:
    """Return a line for every policy carried to a target: looks at it, and what it scored."""
    target = kin(seed, number)
    told = seen(target, np.random.default_rng([seed, number, 73]))
    looks = trial(target.body, np.random.default_rng([seed, number, 74]))
    known = belief(target.body, told)
    chance = np.random.default_rng([seed, number, 76])
    mixed = replace(told, command=told.command[chance.permutation(len(told.command))])
    unsure = belief(target.body, mixed)
    point = replace(known, root=np.zeros_like(known.root))
    plain = _least_squares(told)
    still = target.body.score(still_law(len(looks.low)), rows=ROWS, seed=seed)
    rests = {
        name: _ahead(which, None, looks, seed, number, None)
        for name, which in (("known", known), ("mixed", unsure), ("point", point))
    }
    lines: list[JSON] = []
    for pair in pairs(target, seed, number, told):
        law = linear_law(pair.gain)
        ahead = {
            name: _ahead(which, law, looks, seed, number, rests[name].still)
            for name, which in (("known", known), ("mixed", unsure), ("point", point))
        }
        reads, wanted = wanted_of(pair.source, target.body)
        lines.append(
            {
                "target": target.name,
                "family": target.family,
                "source": pair.source.name,
                "sort": pair.sort,
                "score": target.body.score(law, rows=ROWS, seed=seed),
                "still": still,
                "own": target.own,
                "features": [*ahead["known"].features],
                "shuffled": [*ahead["mixed"].features],
                "point": [*ahead["point"].features],
                "gain": float(ahead["known"].gain.mean()),
                "agreement": agreement(reads, wanted, plain, pair.gain, told.state),
                "one step": _one_step(target.body.outcome, plain, pair.gain, told.state),
            }
        )
    return {"lines": lines}


def _ahead(
    known: Belief, law: Law | None, looks: TrialTask, seed: int, number: int, still: Array | None
) -> PredictedScores:
    """Return what is foreseen; every policy of a target meets the same chance."""
    rng = np.random.default_rng([seed, number, 75])
    act = still_law(len(looks.low)) if law is None else law
    # Where nothing is unknown draws differ by noise alone, and fewer do.
    draws = 64 if known.root.any() else 8
    return foreseen(known, act, looks, rng, draws=draws, still=still)


def _one_step(outcome: Array, law: Array, gain: Array, state: Array) -> float:
    """Return how much more the task's outcome grows in a period than under holding still."""
    n = state.shape[1]
    still = state @ law[:, :n].T
    under = still + state @ gain.T @ law[:, n:].T
    sizes = [float(np.square(each @ outcome.T).sum()) for each in (under, still)]
    return float(np.log(max(sizes[0], 1e-12) / max(sizes[1], 1e-12)))


def _least_squares(told: Transitions) -> Array:
    z = np.concatenate([told.state, told.command], axis=1)
    return np.asarray(np.linalg.lstsq(z, told.after, rcond=None)[0].T)
