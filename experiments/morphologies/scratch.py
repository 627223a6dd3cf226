"""Learning to balance from nothing: evolution strategies on linear feedback, runs of the target.

Source: Salimans, Ho, Chen, Sidor and Sutskever 2017, Evolution Strategies as a Scalable
Alternative to Reinforcement Learning (pairs of opposite moves, ranked).
"""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.policy_transfer.body import Body, linear_law

SIZES = (0.03, 0.1, 0.3)
"""Sizes of the moves that are tried: shares of half a range per unit of state."""

PAIRS = 8
"""Pairs of opposite moves a generation; each is run once."""


def scratch(
    target: Body, *, size: float, generations: int, enough: float, seed: int
) -> tuple[float, bool]:
    """Return how many transitions were used until the score is enough, and whether it ever is.

    A run counts until the body has fallen; what judges a generation is not counted.
    """
    rng = np.random.default_rng([seed, 13])
    low, high = target.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    gain = np.zeros((len(half), target.size))
    spent = 0.0
    for _ in range(generations):
        moves = rng.standard_normal((PAIRS, *gain.shape))
        tried = gain + size * half[:, None] * np.concatenate([moves, -moves])
        scores, used = _runs(target, tried, rng)
        spent += used
        rank = np.argsort(np.argsort(scores)) / (len(scores) - 1.0) - 0.5
        step = np.einsum("i,ijk->jk", rank[:PAIRS] - rank[PAIRS:], moves) / PAIRS
        gain = gain + 2.0 * size * half[:, None] * step
        if target.score(linear_law(gain), rows=3, seed=seed) >= enough:
            return spent, True
    return spent, False


def _runs(target: Body, gains: Array, rng: np.random.Generator) -> tuple[Array, float]:
    with np.errstate(over="ignore", invalid="ignore"):
        moved = target.run(
            lambda x, time: np.einsum("rij,rj->ri", gains, x), rows=len(gains), rng=rng
        )
        reward = target.upright.reward(moved)
    score = np.nan_to_num(reward.mean(axis=-1))
    if moved.stable is not None:
        score = np.where(moved.stable, score, 0.0)
    return np.asarray(score), float((reward > 0.0).sum())
