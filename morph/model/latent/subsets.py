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

    constant: float
    """c."""
    hessian: Array
    """H, shape (p, p)."""
    slope: Array
    """h, shape (p,)."""

    def best(self, precision: Array) -> Array:
        """Return the most probable parameters under a normal prior about 0, shape (p,)."""
        return np.asarray(np.linalg.solve(self.hessian + np.diag(precision), self.slope))

    def evidence(self, precision: Array) -> float:
        """Return the log evidence under a normal prior about 0.

        Source: Bishop 2006, eq. 3.86, for a prior of any diagonal precision.

        Args:
            precision: One over the prior's variances, shape (p,).
        """
        whole = self.hessian + np.diag(precision)
        determinant = float(np.linalg.slogdet(whole)[1] - np.log(precision).sum())
        fit = 0.5 * float(self.slope @ self.best(precision))
        return self.constant + fit - 0.5 * determinant


@dataclass(frozen=True, kw_only=True)
class Subset:
    """Some figures that changed, the others trusted."""

    changed: tuple[int, ...]
    """Which."""
    evidence: float
    """Log evidence, less what the changes cost beforehand."""


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
        precision = precision_of(chosen, free, trusted, changeable)
        log = likelihood.evidence(precision) - DEAR * len(chosen)
        found.append(Subset(changed=chosen, evidence=log))
    return tuple(sorted(found, key=lambda each: -each.evidence))


def precision_of(changed: tuple[int, ...], free: Array, trusted: Array, changeable: int) -> Array:
    """Return the prior's precision if these figures changed and the others did not, (p,)."""
    precision = free.copy()
    still = [at for at in range(changeable) if at not in changed]
    precision[still] = trusted[still]
    return precision


def _sets(count: int) -> Iterator[tuple[int, ...]]:
    for size in range(min(MOST, count) + 1):
        yield from itertools.combinations(range(count), size)
