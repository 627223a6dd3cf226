"""How alike two bodies are for a task: what a policy of one would be worth on the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.belief import Belief
from morph.alignment.errors import SamplesError
from morph.alignment.guard import Law, TrialTask, foreseen

LINES = 64
"""Directions on which clouds of transitions are compared."""


def certain(law: Array, *, noise: Array) -> Belief:
    """Return the belief of who has a linear model of a body, such as its description's.

    Args:
        law: F of x' = F (x; u), shape (n, n + k).
        noise: Standard deviation of a reading, shape (n,).
    """
    return Belief(
        base=law,
        lift=np.eye(len(law)),
        mean=np.zeros_like(law),
        root=np.zeros((law.size, law.size)),
        noise=noise,
        steady=0.0,
        bend=0.0,
        evidence=0.0,
        misfit=1.0,
    )


def promise(
    known: Belief, law: Law, trial: TrialTask, rng: np.random.Generator, *, draws: int = 32
) -> float:
    """Return what a carried policy is expected to score beyond holding still, -1 to 1.

    The likeness of two bodies for a task: the source whose policy promises most is the one to
    carry from. It is no distance: a stiff body may be a good source for a soft one and not the
    other way round.

    Source: Gamboa Higuera 2015, section 4.1 asks for a metric that chooses the source; that the
    policy's own worth be it is ours.

    Args:
        known: What is known of the target near rest.
        law: The source's policy as it would move the target.
        trial: What a run on the target is like.
        rng: Of the bodies drawn and of the noise.
        draws: How many bodies; where nothing is unknown they differ by noise alone.
    """
    return float(foreseen(known, law, trial, rng, draws=draws).gain.mean())


def mean_only(known: Belief) -> Belief:
    """Return the belief of who takes the most probable body for the only one."""
    return replace(known, root=np.zeros_like(known.root))


def apart(ours: Array, theirs: Array, rng: np.random.Generator, *, lines: int = LINES) -> float:
    """Return how far two clouds of transitions are apart: the sliced Wasserstein distance.

    Every number is scaled by its spread over both clouds. On each of many random lines the sorted
    places of both clouds are compared: W^2 = mean over lines of the mean of (a - b)^2.

    Source: Bonneel, Rabin, Peyre and Pfister 2015, J. Mathematical Imaging and Vision 51(1).

    Args:
        ours: A row for each transition, shape (m, d).
        theirs: Likewise, shape (any, d).
        rng: Of the lines.
        lines: How many.

    Raises:
        SamplesError: The rows of the two have not as many numbers.
    """
    if ours.ndim != 2 or theirs.ndim != 2 or ours.shape[1] != theirs.shape[1]:
        raise SamplesError(
            f"transitions have the shapes {ours.shape} and {theirs.shape}",
            where="how far two clouds are apart",
            fix="give both in the same numbers, such as the outcomes of the task",
        )
    spread = np.concatenate([ours, theirs]).std(axis=0)
    spread = np.where(spread > 1e-12, spread, 1.0)
    line = rng.standard_normal((ours.shape[1], lines))
    line /= np.sqrt(np.square(line).sum(axis=0))
    places = (np.arange(100) + 0.5) / 100
    a, b = (np.quantile(each / spread @ line, places, axis=0) for each in (ours, theirs))
    return float(np.sqrt(np.square(a - b).mean()))
