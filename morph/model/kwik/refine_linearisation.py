"""Posterior of a target far from the model, linearised again nearer to it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from morph.arrays import Array
from morph.model.hypothesis import Hypothesis
from morph.model.kwik.belief import belief
from morph.model.kwik.features import Unnamed
from morph.model.kwik.transition_evidence import visit
from morph.model.latent.run import Run
from morph.model.latent.transition_model import Transit

PASSES = 3
"""How often the figures are linearised anew, each time where they were found last."""

FAR = math.log(12.0)
"""Greatest logarithm of a factor that is followed."""


def units(hypothesis: Hypothesis) -> Array:
    """Return what a width of 1 means for each entry of a point: a factor of e, or what is usual.

    Of an effect's parameter that is its own value or, at zero, a twentieth of its range.
    """
    start, known = hypothesis.start, len(hypothesis.knobs)
    reach = 0.05 * (hypothesis.high - hypothesis.low)
    usual = np.where(start == 0.0, reach, np.minimum(np.abs(start), reach))
    return np.where(np.arange(len(start)) < known, 1.0, usual)


def closer(
    transit: Transit,
    runs: Sequence[Run],
    noise: Array,
    epsilon: Array,
    count: int,
    rng: np.random.Generator,
) -> tuple[Array, Array, Unnamed]:
    """Return targets drawn from what is believed of the one that made the runs.

    The gate asks about errors near epsilon and linearises at the model; here figures may differ
    by a factor, so they are linearised where they were found, a few times (Gauss-Newton).

    Returns:
        Points of the hypothesis, (count, p); weights of what is not named, (count, weights); and
        what they weigh.
    """
    hypothesis, point = transit.hypothesis, transit.hypothesis.start
    known = np.arange(len(point)) < len(hypothesis.knobs)
    low = np.where(known, -FAR, hypothesis.low)
    high = np.where(known, FAR, hypothesis.high)
    for number in range(PASSES):
        seen = visit(transit, runs, noise, epsilon, point)
        held = belief(seen.until(len(seen)), seen.named, units(hypothesis), seen.unnamed.smooth)
        change = np.einsum("sr,srp->p", held.weight, held.mean)
        if number == 0:
            # Most figures act in proportion to the factor, not to its logarithm.
            change = np.where(known, np.log(np.maximum(1.0 + change, math.exp(-FAR))), change)
        point = np.clip(hypothesis.start + change, low, high)
    drawn = rng.permutation(held.draws(count, rng))
    points = np.clip(hypothesis.start + drawn[:, : len(point)], low, high)
    return points, drawn[:, len(point) :], seen.unnamed
