"""The fewest changes that explain runs: what was inferred, held to the description where it may."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.information import Information
from morph.model.gaussian.states import ReducedEquations
from morph.model.hypothesis import Hypothesis
from morph.model.latent.infer import Inferred, infer
from morph.model.latent.subsets import DEAR, Subset, subsets
from morph.model.latent.unknowns import TRUSTED, WIDE

PRICE = 4.0
"""What an effect costs beforehand, log, beyond the logarithm of how many there might be."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SparseChanges:
    """An inference with every figure free, and the few changes that explain as much."""

    free: Inferred
    """Every figure may be anything."""
    held: Inferred
    """Only those of the best set may."""
    order: tuple[Subset, ...]
    """Sets of changed figures, the most probable first."""
    price: float
    """What its added effects cost beforehand, log."""

    @cached_property
    def score(self) -> float:
        """Log probability up to a constant: evidence, changes and effects weighed."""
        return self.held.evidence - DEAR * len(self.order[0].changed) - self.price


def sparse(result: Inferred, noise: Array, price: float) -> SparseChanges:
    """Return what was inferred with the fewest changes that explain it.

    Every small set of figures is weighed by linear algebra; with the best one all is fitted again.

    Args:
        result: With every figure free.
        noise: Standard deviation of each observation, shape (n,).
        price: What its effects cost beforehand, log.
    """
    order = weighed(likelihood_of(result.bands, result.point), result.hypothesis, result.point)
    return SparseChanges(free=result, held=_held(result, order[0], noise), order=order, price=price)


def weighed(result: Information, hypothesis: Hypothesis, point: Array) -> tuple[Subset, ...]:
    """Return every set of changed figures, effects free about where they were found."""
    free, trusted, known = precisions(hypothesis)
    shift = np.concatenate([np.zeros(known), point[known:]])
    return subsets(result.about(-shift), free, trusted, known)


def precisions(hypothesis: Hypothesis) -> tuple[Array, Array, int]:
    """Return precisions if changed and if trusted, shape (p,), and how many figures there are."""
    known = len(hypothesis.knobs)
    free, trusted = hypothesis.trust.copy(), hypothesis.trust.copy()
    free[:known], trusted[:known] = WIDE**-2.0, TRUSTED**-2.0
    return free, trusted, known


def likelihood_of(bands: tuple[ReducedEquations, ...], point: Array) -> Information:
    """Return what runs say about a point, states eliminated, up to what models share."""
    return sum((each.information for each in bands[1:]), bands[0].information).about(point)


def _held(result: Inferred, subset: Subset, noise: Array) -> Inferred:
    """Return all fitted again, with what did not change held to the description."""
    hypothesis = result.hypothesis
    knobs = tuple(
        replace(knob, fraction=WIDE if at in subset.changed else TRUSTED)
        for at, knob in enumerate(hypothesis.knobs)
    )
    begin = result.point.copy()
    still = [at for at in range(len(knobs)) if at not in subset.changed]
    begin[still] = 0.0
    held = replace(hypothesis, knobs=knobs, effects=result.effects)
    integrator = result.transit.integrator
    return infer(held, result.runs, noise, integrator=integrator, begin=result, point=begin)
