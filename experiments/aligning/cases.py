"""Cases of the study: two bodies of the shelf, or two formulas that differ in one known way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from experiments.aligning.formula import CartPole, plain, worn
from experiments.aligning.ways import measures, shown_by
from morph.alignment.arrays import Array
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import linear
from morph.alignment.pairs import posed
from morph.arrays import JSON
from morph.policy_transfer.balancers import balancer
from morph.policy_transfer.body import Body, linear_law, still_law
from morph.policy_transfer.mapped.feedback import holding
from morph.policy_transfer.mapped.feedback import plain as plain_feedback
from morph.search.regulator.lqr import noise_aware

SHELF = (
    ("cartpole", "rider_rigid_driven"),
    ("rider_rigid_driven", "cartpole"),
    ("cartpole", "cart_two_links_servo"),
    ("cartpole", "cart_three_links_servo"),
    ("rider_rigid_driven", "cart_three_links_servo"),
    ("cartpole", "cart_two_links"),
)
"""Source and target, two of them with the cart-pole and a rider in each other's place."""

PAIRS = 10
"""Landmarks, unless their number is what changes."""

FEW = 5
"""Fewer: less than what an affine map of a body of the shelf has numbers a row."""

COUNTS = (400, 200)
"""Transitions of the source and of the target."""

LEVELS: dict[str, tuple[float, ...]] = {
    "pairs": (1, 2, 3, 4, 6, 10),
    "length": (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0),
    "mass": (0.1, 0.3, 3.0, 10.0),
    "extra": (1, 2, 4, 8),
    "bend": (0.1, 0.2, 0.4, 0.8),
    "noise": (0.0, 0.05, 0.1, 0.3),
    "error": (0.0, 0.2, 0.5, 1.0),
}
"""What changes, and how far: landmarks, pole's length and mass as factors of the source's, numbers
that move by themselves, how much what is seen is bent, noise and labeller's error in spreads."""

RUNS = 12
"""Runs of a shelf's body that score a map."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One case."""

    seed: int
    """Of all chance."""
    source: str
    """The source, or `formula`."""
    target: str
    """The target, or what changes."""
    level: float
    """How far it changes; the number of landmarks for two bodies of the shelf."""


def cases_of(seeds: Sequence[int], *, quick: bool, only: str | None = None) -> list[Case]:
    """Return all cases, seed by seed."""
    if quick:
        two = (("cartpole", "rider_rigid_driven", 10.0), ("formula", "extra", 4.0))
        return [Case(seed=s, source=a, target=b, level=c) for s in seeds for a, b, c in two]
    shelf = [(a, b, float(n)) for n in (PAIRS, FEW) for a, b in SHELF] if only != "sweep" else []
    sweep = [("formula", factor, float(level)) for factor, levels in LEVELS.items()
             for level in levels] if only != "shelf" else []  # fmt: skip
    every = [*shelf, *sweep]
    return [Case(seed=s, source=a, target=b, level=c) for s in seeds for a, b, c in every]


def measured(case: Case) -> JSON:
    """Return what every way shows in a case, and what may foretell it."""
    return _formula(case) if case.source == "formula" else _shelf(case)


@cache
def _body(name: str) -> Body:
    return balancer(name)


def feedback(source: Body) -> Array:
    """Return the source's policy, shape (nu, n): gentle, since every observation is noisy.

    What a hop starts from is stiffer (`holding`), and what is stiff is seen less well through a
    map that is not exact.
    """
    low, high = source.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    A, B = source.linear
    return noise_aware(
        A,
        B,
        source.outcome.T @ source.outcome + 1e-4 * np.eye(source.size),
        np.diag(half**-2.0),
        np.full(source.size, source.task.noise),
        where=source.task.robot.name,
        bounds=half,
    ).gain


def _share(body: Body) -> float:
    # A servo's command is a place: large ones throw the body about. A motor's is a force.
    return 0.1 if body.task.robot.name.endswith("servo") else 0.5


def _shelf(case: Case) -> JSON:
    source, target = _body(case.source), _body(case.target)
    rng = np.random.default_rng([case.seed, 5])
    ours = source.transitions(COUNTS[0], rng, share=_share(source))
    theirs = target.transitions(COUNTS[1], rng, share=_share(target))
    pairs = posed(theirs.state, source.outcome, target.outcome, int(case.level), rng)
    given = MapData(source=ours, target=theirs, pairs=pairs)
    gain = feedback(source)

    def score(found: AffineMap) -> float:
        law = np.concatenate([np.zeros((1, target.size)), np.eye(target.size)])
        told = found.action(law, found.state(law) @ gain.T)
        through = linear_law((told[1:] - told[0]).T, told[0])
        return target.score(through, rows=RUNS, seed=case.seed)

    looks = (source.outcome, target.outcome)
    law = np.linalg.pinv(source.outcome) @ target.outcome
    ways = shown_by(given, looks, law, score, case.seed)
    runs = {"rows": RUNS, "seed": case.seed}
    ways["hold still"] = {"score": target.score(still_law(len(target.bounds[0])), **runs)}
    ways["oracle"] = {"score": target.score(linear_law(holding(target)), **runs)}
    model = linear(theirs)
    alone = plain_feedback(np.concatenate([model.A, model.B], axis=1), target)
    ways["no source"] = {"score": target.score(linear_law(alone), **runs)}
    return {"ways": ways, "measures": measures(given)}


def _formula(case: Case) -> JSON:
    rng = np.random.default_rng([case.seed, 6])
    at = {"pairs": float(PAIRS), "length": 1.0, "mass": 1.0, "extra": 0.0, "bend": 0.0,
          "noise": 0.02, "error": 0.05} | {case.target: case.level}  # fmt: skip
    first = CartPole()
    other = replace(first, length=first.length * at["length"], pole=first.pole * at["mass"])
    here = plain(first, 0.02)
    there = worn(other, int(at["extra"]), at["bend"], at["noise"], rng)
    ours, theirs = here.transitions(COUNTS[0], rng), there.transitions(COUNTS[1], rng)
    to_units = np.diag(1.0 / here.spread)
    law = to_units @ there.law
    pairs = posed(theirs.state, np.eye(4), law, int(at["pairs"]), rng, error=at["error"])
    given = MapData(source=ours, target=theirs, pairs=pairs)
    gain = first.gain() @ np.diag(here.spread)

    def score(found: AffineMap) -> float:
        return there.score(found, gain, np.random.default_rng([case.seed, 7]))

    ways = shown_by(given, (np.eye(4), law), law, score, case.seed)
    return {"ways": ways, "measures": measures(given)}
