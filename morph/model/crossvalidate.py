"""How sure a gain is: blocked cross-validation by linear algebra."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from morph.arrays import Array, Integers
from morph.model.fit import Fit, room
from morph.model.segments import Segments
from morph.model.shooting import loss, predict

MATERIAL = 0.05
"""Least share of the loss that a parameter must take away: less is not worth a name."""
MOST_FOLDS = 6
"""More folds than this only cost time."""


def folds(segments: Segments) -> Integers:
    """Return each segment's fold, shape (segments,).

    Whole sessions are left out together where there are at least three, else whole
    episodes where there are at least three, else stretches of time.
    """
    sessions = [segments.episodes[index].session for index in segments.episode]
    names = sorted(set(sessions))
    if len(names) >= 3:
        return np.array([names.index(s) for s in sessions]) % MOST_FOLDS
    if len(set(segments.episode.tolist())) >= 3:
        _, order = np.unique(segments.episode, return_inverse=True)
        return np.asarray(order % MOST_FOLDS)
    stretches = min(4, len(segments))
    return np.arange(len(segments)) * stretches // len(segments)


SHARES = (1.0, 0.5, 0.2, 0.0)
"""Shares of a fold's own change that are tried; the training segments choose."""


def validated(found: Fit, segments: Segments, fold: Integers) -> Array:
    """Return each segment's loss under a fit to all other folds, shape (segments,).

    A fold is left out by solving a small linear system about the whole fit (see
    `Quadratic`), not by fitting anew. All folds' solutions, and shares of them in case
    the loss bends, are then simulated in one batch; the training segments choose the
    share, and the segments left out are scored.
    """
    space = room(found.hypothesis, found.point)
    curve, outs = found.quadratic, np.unique(fold)
    points, starts = [], []
    for out in outs:
        inside = fold != out if len(outs) > 1 else fold == out
        change = space.best_change(
            curve.hessian[inside].sum(axis=0), curve.slope[inside].sum(axis=0), found.point
        )
        for share in SHARES:
            points.append(found.point + share * change)
            starts.append(curve.starts_after(found.start, share * change, 0.0))
    read = predict(found.hypothesis, segments, points, starts)
    table = np.stack(
        [
            found.weight * loss(segments, r, s, found.scale)
            for r, s in zip(read, starts, strict=True)
        ]
    ).reshape(len(outs), len(SHARES), len(fold))
    losses = np.empty(len(fold))
    for row, out in enumerate(outs):
        inside = fold != out if len(outs) > 1 else fold == out
        price = [space.price(points[row * len(SHARES) + k]) for k in range(len(SHARES))]
        chosen = int(np.argmin(table[row][:, inside].sum(axis=1) + price))
        losses[fold == out] = table[row, chosen, fold == out]
    return losses


@dataclass(frozen=True, kw_only=True)
class Gain:
    """How much a candidate lowers the cross-validated loss, and how surely."""

    mean: float
    """Share of the loss that it takes away, over all segments."""
    low90: float
    """The same for a typical segment, less what chance and the tries may have added."""

    @property
    def sure(self) -> bool:
        """Whether the gain holds with 90 % confidence after correction for all tries."""
        return self.low90 > 0.0


def gain(before: Array, after: Array, tries: int) -> Gain:
    """Return the gain from paired losses of segments, corrected for the tries (Bonferroni).

    Two of Student's tests are made, and count as two tries: on the differences of the
    losses, which the violent segments decide, and on the logarithms of their ratios,
    in which each segment has one voice. A gain that is sure by either is sure.

    Args:
        before: Loss of each segment without the candidate, shape (segments,).
        after: The same with it.
        tries: How many candidates were looked at.
    """
    # Neighbouring segments share errors, so they count as pairs of neighbours.
    old, new = _paired(before), _paired(after)
    mean = 1.0 - float(after.sum()) / (float(before.sum()) + 1e-30)
    if len(old) < 3:
        return Gain(mean=mean, low90=-np.inf)
    floor = 0.05 * float(np.median(old)) + 1e-30
    by_ratio = _low(np.log((old + floor) / (new + floor)), 2 * tries)
    by_difference = _low(old - new, 2 * tries) / (float(old.mean()) + 1e-30)
    return Gain(mean=mean, low90=max(1.0 - float(np.exp(-by_ratio)), by_difference))


def _low(values: Array, tries: int) -> float:
    """Return the lower end of a 90 % interval of the mean, corrected for the tries."""
    error = float(values.std(ddof=1)) / np.sqrt(len(values)) + 1e-12
    quantile = float(student.ppf(1.0 - 0.10 / max(tries, 1), len(values) - 1))
    return float(values.mean() - quantile * error)


def _paired(values: Array) -> Array:
    whole = values[: len(values) // 2 * 2].reshape(-1, 2).mean(axis=1)
    return np.append(whole, values[-1]) if len(values) % 2 else whole


def probabilities(
    losses: dict[str, Array], complexity: dict[str, int], seed: int
) -> dict[str, float]:
    """Return how often each model is best when the segments are drawn anew.

    Each draw of segments, with replacement, picks the model with the least loss, where
    every parameter must earn the share that makes a finding worth a name.

    Source: Efron and Tibshirani 1993, chapter 17.

    Args:
        losses: Cross-validated loss of each segment by model, shape (segments,) each.
        complexity: Parameters of each model's effects.
        seed: Of the draws.
    """
    names = list(losses)
    table = np.stack([losses[name] for name in names])
    rng = np.random.default_rng(seed)
    draws = rng.integers(table.shape[1], size=(2000, table.shape[1]))
    totals = table[:, draws].sum(axis=2)
    handicap = 1.0 + MATERIAL * np.array([complexity[name] for name in names])
    best = np.argmin(totals * handicap[:, None], axis=0)
    return {name: float(np.mean(best == index)) for index, name in enumerate(names)}
