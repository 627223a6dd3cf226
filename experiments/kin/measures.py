"""How well harm was foreseen, and how well sources were chosen: figures of both studies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.stats import rankdata

from morph.arrays import JSON, Array, Mask

Rows = npt.NDArray[np.intp]
"""Numbers of pairs, shape (any,)."""

CLEAR = 0.1
"""What a useful policy scores beyond holding still, at least."""

ALIKE = 0.02
"""How far below the best source's jumpstart the chosen one's may be: two standard errors of the
mean of 40 runs whose scores spread by 0.06."""

DRAWS = 1000
"""Bootstrap samples of an interval, each of as many targets with putting back."""


def area(harmful: Mask, suspicion: Array) -> float:
    """Return the area under the curve: how often a harmful pair is the more suspect of two.

    Source: Hanley and McNeil 1982, Radiology 143(1): it is the Mann-Whitney statistic.

    Args:
        harmful: Which pairs are, shape (n,), some and not all.
        suspicion: The more the likelier to be harmful; equal ones count by half, shape (n,).
    """
    rank = rankdata(suspicion)
    bad, good = int(harmful.sum()), int((~harmful).sum())
    return float((rank[harmful].sum() - 0.5 * bad * (bad + 1)) / max(bad * good, 1))


def accepted(harmful: Mask, useful: Mask, suspicion: Array, *, share: float = 0.02) -> float:
    """Return the share of the useful accepted where so many of the harmful are.

    The threshold is the highest at which at most that share of the harmful pairs is at or below
    it; a tie with a harmful pair that is not accepted is not accepted either.
    """
    bad = np.sort(suspicion[harmful])
    allowed = int(np.floor(share * len(bad)))
    bound = bad[allowed] if allowed < len(bad) else np.inf
    return float((suspicion[useful] < bound).mean()) if useful.any() else 0.0


def within(
    groups: Sequence[str], of: Callable[[Rows], float], *, seed: int = 0
) -> tuple[float, float]:
    """Return the bootstrap 95 % interval of a figure; pairs of one target go together.

    Args:
        groups: The target of each pair.
        of: The figure, of the numbers of the pairs drawn.
        seed: Of the draws.
    """
    rng = np.random.default_rng(seed)
    _, at = np.unique(np.array(groups), return_inverse=True)
    rows = [np.flatnonzero(at == each) for each in range(at.max() + 1)]
    # Of few targets most draws are the same.
    figure = cache(lambda drawn: of(np.concatenate([rows[each] for each in drawn])))
    found = [figure((*rng.integers(len(rows), size=len(rows)),)) for _ in range(DRAWS)]
    low, high = np.nanquantile(found, (0.025, 0.975))
    return float(low), float(high)


def calibration(harmful: Mask, probability: Array, edges: Sequence[float]) -> list[JSON]:
    """Return for each bin of probability how many pairs fell into it, and how many did harm."""
    lines = []
    for low, high in pairwise(edges):
        held = (probability >= low) & (probability < high)
        if held.any():
            lines.append(
                {
                    "from": low,
                    "to": high,
                    "pairs": int(held.sum()),
                    "foreseen": float(probability[held].mean()),
                    "harmful": float(harmful[held].mean()),
                }
            )
    return lines


def chosen_well(targets: Sequence[str], promise: Array, jumpstart: Array) -> Array:
    """Return for each target whether the most promising source is, within noise, the best."""
    right = []
    for name in dict.fromkeys(targets):
        held = np.array([each == name for each in targets])
        worth = jumpstart[held]
        right.append(float(worth[int(np.argmax(promise[held]))] >= worth.max() - ALIKE))
    return np.array(right)


def lines_of(rows: Sequence[JSON]) -> list[JSON]:
    """Return the lines of all targets; a target that was refused is a line that says why."""
    return [line for row in rows for line in row.get("lines", [row])]
