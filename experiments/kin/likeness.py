"""One target of the study of similarity: six sources, what each promised and what it gave."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from experiments.kin.bodies import FAMILIES, Kin, Source, described, kin, source
from experiments.kin.carried import agreement, by_features, wanted_of
from experiments.kin.pairs import PLANAR
from experiments.kin.seen import WAYS, belief, moved, seen, trial
from morph.alignment.metric import apart, certain, mean_only, promise
from morph.alignment.samples import Transitions
from morph.alignment.tracking_feasibility import following
from morph.arrays import JSON, Array
from morph.policy_transfer.body import linear_law, still_law

EACH = 4
"""Bodies of a seed."""

SOURCES = 6
"""Sources of a target: half of its own family, half planar ones."""

ROWS = 40
"""Runs of the target by which a source's worth is measured."""


@lru_cache(maxsize=64)
def drawn_source(seed: int, number: int) -> Source:
    """Return a body of the study as a source of others."""
    family = FAMILIES[(EACH * seed + number) % len(FAMILIES)]
    return source(family, np.random.default_rng([seed, number, 71]), f"{family} {seed}.{number}")


def likeness(seed: int, number: int) -> JSON:
    """Return a line for every source of a target; the sources are bodies of the same ten seeds."""
    target = kin(seed, number)
    rng = np.random.default_rng([seed, number, 82])
    told = seen(target, np.random.default_rng([seed, number, 73]))
    looks = trial(target.body, np.random.default_rng([seed, number, 74]))
    known = belief(target.body, told)
    law = np.concatenate(target.body.linear, axis=1)
    sure = certain(law, noise=known.noise)
    still = target.body.score(still_law(len(looks.low)), rows=ROWS, seed=seed)
    lines: list[JSON] = []
    for at, other in enumerate(_sources(seed, number, target.family, rng)):
        gain = _carried(other, target)
        if gain is None:
            continue
        act = linear_law(gain)
        reads, wanted = wanted_of(other, target.body)
        lines.append(
            {
                "target": target.name,
                "source": other.name,
                "jumpstart": target.body.score(act, rows=ROWS, seed=seed) - still,
                "promise by description": promise(sure, act, looks, _rng(seed, number), draws=8),
                "promise of 60": promise(known, act, looks, _rng(seed, number)),
                "promise of the mean": promise(
                    mean_only(known), act, looks, _rng(seed, number), draws=8
                ),
                "agreement": agreement(reads, wanted, law, gain, told.state),
                **_clouds(other, target, told, rng),
                "figures": _figures(other, target),
                "name": float(other.name.split()[0] == target.family),
                "random": float(rng.random()),
                "at": at,
            }
        )
    return {"lines": lines}


def _rng(seed: int, number: int) -> np.random.Generator:
    return np.random.default_rng([seed, number, 75])


def _sources(seed: int, number: int, family: str, rng: np.random.Generator) -> list[Source]:
    ten = 10 * (seed // 10)
    every = [(s, n) for s in range(ten, ten + 10) for n in range(EACH) if (s, n) != (seed, number)]
    named = {case: FAMILIES[(EACH * case[0] + case[1]) % len(FAMILIES)] for case in every}
    like = [case for case in every if named[case] == family]
    planar = [case for case in every if named[case] in PLANAR and named[case] != family]
    half = SOURCES // 2
    picked = [like[i] for i in rng.permutation(len(like))[:half]]
    picked += [planar[i] for i in rng.permutation(len(planar))[:half]]
    return [drawn_source(*case) for case in picked]


def _carried(other: Source, target: Kin) -> Array | None:
    """Return the policy as it is on its own family, by the shelf's description elsewhere."""
    if other.name.split()[0] == target.family:
        return other.gain
    A, B = described(target.family).body.linear
    return by_features(other, target, np.concatenate([A, B], axis=1))


def _clouds(other: Source, target: Kin, told: Transitions, rng: np.random.Generator) -> JSON:
    """Return likenesses of what both were seen to do, in the outcomes that both have."""
    family = other.name.split()[0]
    ours = moved(other.body, len(told.state), *WAYS[family], rng)
    theirs, _ = wanted_of(other, target.body)
    mine = other.body.outcome[: len(theirs)] if len(theirs) == 4 else other.body.outcome
    rows = [0, len(mine) // 2] if len(theirs) == 2 else range(len(theirs))
    mine = mine[list(rows)]
    clouds = [
        Transitions(
            state=each.state @ reads.T,
            command=each.command,
            after=each.after @ reads.T,
            turns=np.zeros(len(reads), dtype=bool),
        )
        for each, reads in ((ours, mine), (told, theirs))
    ]
    shares = following(clouds[0], clouds[1]).share
    here, there = (np.concatenate([each.state, each.after - each.state], axis=1) for each in clouds)
    return {"eq. 11": shares["relative"], "Wasserstein": -apart(here, there, rng)}


def _figures(other: Source, target: Kin) -> float:
    """Return how alike mass and height are, 0 at best: minus the sum of both logs' differences."""
    sizes = []
    for each in (other.body, target.body):
        sizes.append((each.task.robot.mass, abs(each.upright.rest[2])))
    return -float(np.abs(np.log(sizes[0]) - np.log(sizes[1])).sum())
