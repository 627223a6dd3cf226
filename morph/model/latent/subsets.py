"""Which figures of a description must have changed: every small set, by linear algebra."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array

MOST = 3
"""Most figures that are taken to have changed at once."""

DEAR = 2.0
"""What each changed figure costs beforehand, in log probability: odds of seven to one against."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Likelihood:
    """log p(runs | theta) about its top: c - theta' H theta / 2 + h' theta."""

    hessian: Array
    """H, shape (p, p)."""
    slope: Array
    """h, shape (p,)."""

    def evidence(self, precision: Array) -> float:
        """Return the log evidence, less c, under a normal prior about 0.

        Source: Bishop 2006, eq. 3.86, for a prior of any diagonal precision.

        Args:
            precision: One over the prior's variances, shape (p,).
        """
        whole = self.hessian + np.diag(precision)
        best = np.linalg.solve(whole, self.slope)
        determinant = float(np.linalg.slogdet(whole)[1] - np.log(precision).sum())
        return 0.5 * float(self.slope @ best) - 0.5 * determinant


@dataclass(frozen=True, kw_only=True)
class Subset:
    """Some figures that changed, the others trusted."""

    changed: tuple[int, ...]
    """Which."""
    evidence: float
    """Its log probability, up to what all share."""


def subsets(
    likelihood: Likelihood, free: Array, trusted: Array, changeable: int
) -> tuple[Subset, ...]:
    """Return every set of up to `MOST` changed figures, the most probable first.

    Args:
        likelihood: Of all parameters.
        free: Precision of each parameter's prior if it changed, shape (p,).
        trusted: The same if it did not.
        changeable: How many parameters, the first ones, may be either; the others are free.
    """
    found = []
    for chosen in _sets(changeable):
        precision = free.copy()
        still = [at for at in range(changeable) if at not in chosen]
        precision[still] = trusted[still]
        log = likelihood.evidence(precision) - DEAR * len(chosen)
        found.append(Subset(changed=chosen, evidence=log))
    return tuple(sorted(found, key=lambda each: -each.evidence))


def _sets(count: int) -> Iterator[tuple[int, ...]]:
    for size in range(min(MOST, count) + 1):
        yield from itertools.combinations(range(count), size)
