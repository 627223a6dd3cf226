"""Pairs of a policy and a body: where it comes from, how it is carried, and what comes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.kin.bodies import Kin, Source, described, source
from experiments.kin.carried import by_features, flipped, scaled, shuffled
from experiments.kin.seen import belief
from morph.alignment.errors import AlignError
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.errors import MorphError
from morph.policy_transfer.hop import hop

FEW = 20
"""Transitions of the target that a hasty map is learned from."""

PLANAR = ("cartpole", "rider_rigid_driven", "rider_rigid_passive")
"""Families that have one lean and no more, whose policies any body can be asked to follow."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """A policy that was made for one body, as it would move another."""

    source: Source
    """Whose policy it was."""
    sort: str
    """How it is carried."""
    gain: Array
    """K of u = K x on the target, shape (k, n)."""


def pairs(target: Kin, seed: int, number: int, seen: Transitions) -> list[Pair]:
    """Return policies carried to a target in fifteen ways."""
    rng = np.random.default_rng([seed, number, 72])
    like = [source(target.family, rng, f"{target.family} {at}") for at in range(2)]
    planar = [str(rng.choice(PLANAR)) for _ in range(2)]
    other = [source(family, rng, f"{family} {at}") for at, family in enumerate(planar)]
    told = described(target.family)
    A, B = told.body.linear
    old = np.concatenate([A, B], axis=1)
    known, learned = (belief(target.body, _first(seen, m)).law for m in (len(seen.state), FEW))
    hasty = _least_squares(_first(seen, FEW))
    made: list[tuple[Source, str, Array | None]] = [
        (each, "carried as it is", each.gain) for each in (*like, told)
    ]
    made += [(each, "by an old description", by_features(each, target, old)) for each in other]
    made.append((other[0], "learned of 60", by_features(other[0], target, known)))
    made.append((other[0], "learned of 20", by_features(other[0], target, learned)))
    made.append((other[1], "learned of 20 in haste", by_features(other[1], target, hasty)))
    made.append((other[0], "hop", _hopped(other[0], target, seen, seed)))
    bases = [each for each in made if each[2] is not None]
    for wrong in (flipped, flipped, flipped, shuffled, shuffled, scaled):
        # Wrongs of a good map are the ones that must be told from it.
        whose, _, gain = bases[int(rng.integers(len(bases)))]
        if gain is not None:
            made.append((whose, wrong.__name__, wrong(gain, rng)))
    return [Pair(source=a, sort=b, gain=c) for a, b, c in made if c is not None]


def _hopped(source: Source, target: Kin, seen: Transitions, seed: int) -> Array | None:
    """Return the gain that a whole hop of the library gives, if it gives one."""
    try:
        return hop(source.body, target.body, seen, seed=seed, source_gain=source.gain).gain
    except (MorphError, AlignError, np.linalg.LinAlgError, ValueError):
        return None


def _first(seen: Transitions, count: int) -> Transitions:
    return Transitions(
        state=seen.state[:count],
        command=seen.command[:count],
        after=seen.after[:count],
        turns=seen.turns,
    )


def _least_squares(few: Transitions) -> Array:
    z = np.concatenate([few.state, few.command], axis=1)
    return np.asarray(np.linalg.lstsq(z, few.after, rcond=1e-3)[0].T)
