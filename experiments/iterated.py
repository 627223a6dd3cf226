"""One body of the study of iterations: ten changes of it, and every way to follow them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import numpy as np

from morph.arrays import JSON, Array
from morph.body.load import load
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.iterations import Drift, PrintedBody, first_of, iterations, nearby
from morph.policy_transfer.linear_belief import LinearBelief, anew, regressed, regulator
from morph.search.cmaes import Adapting
from morph.sim.threads import one_thread
from morph.task.balance import balance
from morph.task.push import Push

BODIES = {"cartpole": 0.4, "rider_rigid_driven": 0.4, "cart_two_links": 0.2}
"""Each body and the push on its lowest swinging link, N s per kg of the whole body."""

CHANGES = 10
"""How many iterations."""

COUNT = 6
"""Transitions of each body by which the carried belief is updated."""

FEWER = (0, 2)
"""Fewer transitions, to see from how many on it is enough."""

ANEW = (6, 40, 80, 160)
"""Transitions from which a body is learned anew, until it is enough."""

LOUD = 0.6
"""Commands by which it is: without a source they need be three times as strong."""

ENOUGH = 0.95
"""Share of the oracle's score at which a body counts as learned."""

ROWS = 8
"""Runs by which a law is judged."""

CONTROLLED = (1, 5, 10)
"""Iterations at which the controls run."""

STEPS = (0.1, 0.3, 1.0)
"""First spreads of the search by trials, in largest commands per typical state."""

TRIALS = 144
"""Trials of 5 s that it may make."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One body, one seed, and how far the study goes."""

    body: str
    """Name on the shelf."""
    seed: int
    """Of all its chance."""
    changes: int = CHANGES
    """Iterations."""
    anew: tuple[int, ...] = ANEW
    """Transitions from which each is learned anew."""
    trials: int = TRIALS
    """Of the search from nothing, on the last body; 0 for none."""


@dataclass(kw_only=True)
class Row:
    """What one iteration showed."""

    scores: dict[str, float] = field(default_factory=dict)
    """Score of each way."""
    enough: dict[str, float] = field(default_factory=dict)
    """Transitions of this body after which a way reached ENOUGH; infinite if none did."""


def measured(case: Case) -> JSON:
    """Return how every way does on each iteration of a body."""
    with one_thread():
        return _measured(case)


def _measured(case: Case) -> JSON:
    printed = _printed(case.body)
    changes = iterations(printed, count=case.changes, rng=np.random.default_rng([case.seed, 1]))
    first = printed.body(np.zeros(len(printed.numbers)))
    never = _gain(np.concatenate(first.linear, axis=1), first, first)
    belief = printed.known()
    rows = []
    for number, change in enumerate(changes, 1):
        made = printed.body(change)
        row, belief = _iterated(case, number, printed, made, first, never, belief)
        rows.append(asdict(row))
    return {"body": case.body, "seed": case.seed, "rows": rows}


def _printed(name: str) -> PrintedBody:
    robot = load(name)
    mass = sum(link.mass for link in robot.links)
    push = Push(link=robot.joints[1].link, impulse=(BODIES[name] * mass, 0.0, 0.0))
    return PrintedBody(described=robot, pose=balance, push=push, drift=Drift())


def _gain(W: Array, task: Body, bounds: Body) -> Array:
    return regulator(W, task.outcome, bounds.bounds, noise=bounds.task.noise)


def _iterated(
    case: Case,
    number: int,
    printed: PrintedBody,
    made: Body,
    first: Body,
    never: Array,
    belief: LinearBelief,
) -> tuple[Row, LinearBelief]:
    """Return what one iteration shows, and what is believed after it."""
    rng = np.random.default_rng([case.seed, 2, number])
    shown = nearby(made, COUNT, rng)
    loud = nearby(made, max(case.anew), rng, share=LOUD)
    row = Row()

    def scored(gain: Array) -> float:
        return made.score(linear_law(gain), rows=ROWS, seed=1000 * case.seed + number)

    oracle = _gain(np.concatenate(made.linear, axis=1), made, made)
    row.scores |= {"oracle": scored(oracle), "never adjusted": scored(never)}
    good = ENOUGH * row.scores["oracle"]
    before = belief.changed(printed.spread)
    row.enough["carried"] = np.inf
    for count in (*FEWER, COUNT):
        after = before.seen(first_of(shown, count), noise=made.task.noise) if count else before
        law = _gain(after.linear, printed.body(after.mean), made)
        score = scored(law)
        row.scores[f"carried {count}" if count < COUNT else "carried"] = score
        if score >= good:
            row.enough["carried"] = min(row.enough["carried"], count)
    for way in ("anew", "regressed"):
        row.enough[way] = np.inf
        for count in case.anew:
            seen = first_of(loud, count)
            W = (
                anew(seen, made.task.period, noise=made.task.noise)
                if way == "anew"
                else regressed(seen)
            )
            score = scored(_gain(W, first, made))
            row.scores[f"{way} {count}"] = score
            if score >= good:
                row.enough[way] = count
                break
    if number in CONTROLLED:
        mixed = _deranged(made.size, rng)
        row.scores |= {
            "still": scored(np.zeros_like(law)),
            "flipped": scored(-law),
            "shuffled": scored(law[:, mixed]),
        }
    if number == case.changes and case.trials:
        score, spent = _scratch(made, case, good, scored)
        row.scores["scratch"], row.enough["scratch"] = score, spent
    return row, after


def _deranged(count: int, rng: np.random.Generator) -> list[int]:
    """Return a permutation that leaves nothing in its place."""
    mixed = rng.permutation(count)
    while (mixed == np.arange(count)).any():
        mixed = rng.permutation(count)
    return [int(each) for each in mixed]


def _scratch(
    made: Body, case: Case, good: float, scored: Callable[[Array], float]
) -> tuple[float, float]:
    """Return the best score of a search by trials over all step sizes, and after how many samples.

    Each trial is one run of the task; the step size that did best counts, and the others' trials
    are not charged to it.
    """
    low, high = made.bounds
    half = np.minimum(np.minimum(-low, high), 2.0 * np.pi)
    size = made.size
    typical = np.repeat([0.2, 1.0], size // 2)
    unit = half[:, None] / typical
    length = round(made.task.horizon / made.task.period)
    best, spent = 0.0, np.inf
    for step in STEPS:
        rng = np.random.default_rng([case.seed, 3])
        search = Adapting(np.full(unit.size, 0.5), 0.5 * step / 2.0, 12, None)
        for generation in range(1, case.trials // 12 + 1):
            points = np.clip(search.ask(12, rng), 0.0, 1.0)
            gains = [(4.0 * point - 2.0).reshape(unit.shape) * unit for point in points]
            scores = _each(made, np.array(gains), rng)
            search.tell(points, -scores)
            # Only a law that did well is judged, at no charge.
            if scores.max() < max(good, best):
                continue
            score = scored(gains[int(scores.argmax())])
            best = max(best, score)
            if score >= good:
                spent = min(spent, 12.0 * generation * length)
                break
    return best, spent


def _each(made: Body, gains: Array, rng: np.random.Generator) -> Array:
    """Return the score of one run under each of some laws u = gain x, shape (laws,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        moved = made.run(
            lambda x, time: np.einsum("rij,rj->ri", gains, x), rows=len(gains), rng=rng
        )
    return made.upright.score(moved)
