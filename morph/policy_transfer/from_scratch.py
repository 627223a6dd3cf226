"""Learning on the target alone from nothing but scores of runs: what any source must beat."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.hop_result import Curve

STEPS = (0.1, 0.3, 1.0)
"""Step sizes that are tried; the best by its own runs is taken, and only its runs are counted."""

DIRECTIONS = 4
"""Directions of a round, each tried both ways."""

ROUNDS = 12
"""Rounds of each step size."""

RATE = 0.2
"""What a unit of speed counts against a unit of place where directions are drawn."""

NAME = "scratch"
"""What it is called among the controls."""


def scratch(body: Body, *, rows: int, seed: int, rounds: int = ROUNDS) -> Curve:
    """Return how good feedback becomes that is searched by augmented random search.

    Each round runs the task with gains moved both ways along drawn directions, and moves the gain
    by the differences of their scores, over the scores' standard deviation. It begins at zero:
    holding still. A run counts with all its control periods.

    Source: Mania, Guy and Recht 2018, NeurIPS, algorithm 1 (version V1).

    Args:
        body: The target.
        rows: Runs over which each round's gain is judged; these are not counted.
        seed: Of directions and runs.
        rounds: How many rounds of each step size.

    Returns:
        The scores after each round, of the best of the step sizes, in one row.
    """
    lines = [_searched(body, step, rows=rows, seed=seed, rounds=rounds) for step in STEPS]
    line = max(lines, key=lambda each: each[-1])
    run = round(body.task.horizon / body.task.period)
    counts = tuple(2 * DIRECTIONS * run * (at + 1) for at in range(rounds))
    return Curve(name=NAME, samples=counts, scores=np.array([line]))


def _searched(body: Body, step: float, *, rows: int, seed: int, rounds: int) -> list[float]:
    rng = np.random.default_rng([seed, 21])
    low, high = body.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    places = body.size // 2
    unit = half[:, None] * np.concatenate([np.ones(places), np.full(places, RATE)])
    theta, line = np.zeros(unit.shape), []
    for at in range(rounds):
        way = rng.standard_normal((DIRECTIONS, *unit.shape))
        tried = np.concatenate([theta + step * way, theta - step * way])
        scores = _scores(body, unit * tried, np.random.default_rng([seed, 22, at]))
        ahead, back = scores[:DIRECTIONS], scores[DIRECTIONS:]
        spread = float(scores.std())
        if spread > 0.0:
            gone = np.einsum("d,dkn->kn", ahead - back, way)
            theta = theta + step / (DIRECTIONS * spread) * gone
        line.append(body.score(linear_law(unit * theta), rows=rows, seed=seed))
    return line


def _scores(body: Body, gains: Array, rng: np.random.Generator) -> Array:
    """Return the score of a run under each gain, shape (gains,)."""

    def law(state: Array, time: Array) -> Array:
        return np.asarray(np.einsum("rkn,rn->rk", gains, state))

    with np.errstate(over="ignore", invalid="ignore"):
        moved = body.run(law, rows=len(gains), rng=rng)
    return np.asarray(body.upright.score(moved))
