"""Landmarks: a few states of two bodies that correspond, and the same ones labelled wrongly."""

from __future__ import annotations

import numpy as np

from morph.alignment.arrays import Array, Integers
from morph.alignment.errors import SamplesError
from morph.alignment.samples import Pairs
from morph.alignment.scale import scale


def spread_out(x: Array, count: int, rng: np.random.Generator) -> Integers:
    """Return which rows to label: each as far as can be from all before it.

    What is far is told by principal components in their own spreads: an unstable body was mostly
    seen along the one motion that grows, and the others are to be labelled too.

    Source: Gonzalez 1985, Theoretical Computer Science 38 (the farthest point next).

    Args:
        x: Data, shape (m, n).
        count: How many, 1 to m.
        rng: The chance of the first.

    Raises:
        SamplesError: There are not so many.
    """
    if not 1 <= count <= len(x):
        raise SamplesError(
            f"{count} of {len(x)} states are to be labelled",
            where="landmarks",
            fix="label at least one, and at most as many as there are",
        )
    axes, _, _ = np.linalg.svd(scale(x)(x), full_matrices=False)
    z = axes * np.sqrt(len(x))
    taken = [int(rng.integers(len(x)))]
    away = np.square(z - z[taken[0]]).sum(axis=1)
    while len(taken) < count:
        taken.append(int(away.argmax()))
        away = np.minimum(away, np.square(z - z[taken[-1]]).sum(axis=1))
    return np.array(taken, dtype=np.int64)


def posed(
    target: Array,
    source_look: Array,
    target_look: Array,
    count: int,
    rng: np.random.Generator,
    *,
    error: float = 0.05,
) -> Pairs:
    """Return landmarks as somebody makes them who poses the source until it looks alike.

    A state x of the source is posed for a state y of the target with C_s x = C_t y, x being the
    least of all that do; the labeller errs by a share of the spread of what was posed.

    Args:
        target: States of the target, from which those to label are chosen, shape (m, n_t).
        source_look: C_s, what the labeller looks at on the source, shape (k, n_s).
        target_look: C_t, the same on the target, shape (k, n_t).
        count: How many.
        rng: The chance of the choice and of the errors.
        error: Standard deviation of the labeller's errors, in spreads.

    Raises:
        SamplesError: There are too few states, or the looks differ in number.
    """
    if len(source_look) != len(target_look):
        raise SamplesError(
            f"{len(source_look)} numbers are looked at on the source, "
            f"{len(target_look)} on the target",
            where="landmarks",
            fix="look at the same quantities of both bodies",
        )
    chosen = target[spread_out(target, count, rng)]
    law = np.linalg.pinv(source_look) @ target_look
    spread = (target @ law.T).std(axis=0)
    source = chosen @ law.T
    return Pairs(source=source + error * spread * rng.standard_normal(source.shape), target=chosen)


def shuffled(pairs: Pairs, rng: np.random.Generator) -> Pairs:
    """Return the same states wrongly paired, no row with its own if there are two or more.

    What a map learned from these scores is what the data score without the labels: the control.
    """
    order = rng.permutation(len(pairs.source))
    # A permutation as a cycle has no fixed point.
    wrong = np.empty_like(order)
    wrong[order] = np.roll(order, 1)
    return Pairs(source=pairs.source[wrong], target=pairs.target)
