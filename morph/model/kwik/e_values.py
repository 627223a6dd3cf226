"""E-values against "good enough" and "not good enough", valid at any stopping time."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.model.kwik.belief import WIDE, ModelPosterior, Sized


def worst(errors: Array, most: int) -> Array:
    """Return the most-th largest over transitions, so that `most` - 1 may exceed it.

    Args:
        errors: Shape (..., transitions).
        most: Counted from 1; not above the number of transitions.
    """
    return np.asarray(np.partition(errors, -most, axis=-1)[..., -most])


def bets(belief: ModelPosterior, unit: Array, error: Array, most: int) -> tuple[float, float]:
    """Return the logarithms of what two bets have won: against "not good", and against "good".

    Each begins with a stake of 1, and wins p(data | mixture) / p(data | theta). For the true theta
    that is a martingale with mean 1, so it ever exceeds 1 / delta with probability at most delta
    (Ville), whatever the mixture is and whenever one stops. A bet against a set is what is won
    against the theta of the set that the data like best. That a transition errs by more than
    epsilon is a half-space of theta: its best theta lies at a distance in closed form. "Not good"
    needs `most` half-spaces at once, so the `most`-th nearest bounds it from below; "good" allows
    `most` - 1 beyond epsilon, so the `most`-th farthest slab bounds it.

    Source: Ville 1939; Howard, Ramdas, McAuliffe and Sekhon 2021, Annals of Statistics 49(2),
    section 3.2 (mixtures); Waudby-Smith and Ramdas 2020, NeurIPS 33, eq. 2.4 (prior over
    posterior, the same bet).

    Args:
        belief: The mixture with its evidence.
        unit: Of the named figures, shape (named,).
        error: The model's error in epsilons, linear in the unknowns, shape
            (transitions, n, unknowns).
        most: How many transitions beyond epsilon make a model not good.
    """
    bad, good = [], []
    for part in belief.parts:
        best, out, within = distances(part, unit, error)
        bad.append(part.log_prior + best - 0.5 * worst(-out, most) ** 2)
        good.append(part.log_prior + best - 0.5 * worst(within, most) ** 2)
    whole = belief.log_evidence
    return whole - float(np.logaddexp.reduce(bad)), whole - float(np.logaddexp.reduce(good))


def distances(part: Sized, unit: Array, error: Array) -> tuple[float, Array, Array]:
    """Return the greatest log likelihood, and how far off each transition's half-spaces are.

    Returns:
        The log likelihood of the best theta; for each transition the distance, in standard
        deviations, to an error beyond epsilon, (transitions,), and to one within, (transitions,).
    """
    p, result = part.named, part.information
    trust = np.concatenate([(WIDE * unit) ** -2.0, part.size**-2.0])
    covariance = np.linalg.inv(result.H + np.diag(trust))
    rows = error.reshape(-1, error.shape[-1])
    guess = np.abs(rows @ (covariance @ result.b)).reshape(error.shape[:2])
    variance = np.einsum("ij,ij->i", rows @ covariance, rows).reshape(error.shape[:2])
    # An error that nothing can cause has no variance, and is never beyond epsilon.
    deviation = np.sqrt(np.maximum(variance, 1e-18))
    out = (np.maximum(1.0 - guess, 0.0) / deviation).min(axis=1)
    within = (np.maximum(guess - 1.0, 0.0) / deviation).max(axis=1)
    named = part.reduced
    best = np.linalg.solve(named.H + np.diag(trust[:p]), named.b)
    return float(0.5 * named.b @ best - 0.5 * named.c), out, within
