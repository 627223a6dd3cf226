"""Which figures of a description must have changed: every small set, by linear algebra."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.information import Information

MOST = 3
"""Most figures that are taken to have changed at once."""

DEAR = 2.0
"""What each changed figure costs beforehand, in log probability: odds of seven to one against."""


@dataclass(frozen=True, kw_only=True)
class Subset:
    """Some figures that changed, the others trusted."""

    changed: tuple[int, ...]
    """Which."""
    evidence: float
    """Log evidence, less what the changes cost beforehand."""


def subsets(
    result: Information, free: Array, trusted: Array, changeable: int
) -> tuple[Subset, ...]:
    """Return every set of up to `MOST` changed figures, the most probable first.

    Args:
        result: What runs say of all parameters.
        free: Precision of each parameter's prior if it changed, shape (p,).
        trusted: The same if it did not.
        changeable: How many parameters, the first ones, may be either; the others are free.
    """
    listed = []
    for chosen in _sets(changeable):
        variance = 1.0 / precision_of(chosen, free, trusted, changeable)
        log = result.with_prior(np.zeros(len(variance)), variance).log_evidence
        listed.append(Subset(changed=chosen, evidence=log - DEAR * len(chosen)))
    return tuple(sorted(listed, key=lambda each: -each.evidence))


def precision_of(changed: tuple[int, ...], free: Array, trusted: Array, changeable: int) -> Array:
    """Return the prior's precision if these figures changed and the others did not, (p,)."""
    precision = free.copy()
    still = [at for at in range(changeable) if at not in changed]
    precision[still] = trusted[still]
    return precision


def _sets(count: int) -> Iterator[tuple[int, ...]]:
    for size in range(min(MOST, count) + 1):
        yield from itertools.combinations(range(count), size)
