"""Which of a model's effects are needed, by the quadratic of its loss and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array, Mask
from morph.model.crossvalidate import MATERIAL
from morph.model.fit import Room, room
from morph.model.hypothesis import Hypothesis
from morph.model.shooting import Quadratic

SURE = 6.0
"""Minus twice the logarithm of odds of 1 to 20: evidence that an effect must have to stay."""


@dataclass(frozen=True, kw_only=True)
class Subset:
    """The loss near a point, of which any effect in question may be left out."""

    hypothesis: Hypothesis
    """With all effects in question."""
    had: int
    """How many of its effects are not in question: the first ones."""
    point: Array
    """Where the quadratic was taken."""
    quadratic: Quadratic
    """The loss of every segment."""

    @property
    def questioned(self) -> list[int]:
        """The effects in question."""
        return list(range(self.had, len(self.hypothesis.effects)))

    def priced(self, kept: Sequence[int]) -> float:
        """Return minus twice the log evidence for some of the effects.

        The loss, in units of the noise, is minus twice the log likelihood, and what is known
        beforehand is normal: the evidence follows by Laplace's approximation. What the data do
        not tell costs nothing, and what they tell costs the more the less it was expected.

        Source: MacKay 1992, Neural Computation 4(3), eq. 2.5.
        """
        free, hessian = ~self._idle(kept), self._total[0]
        trust = self.hypothesis.trust[free]
        told = hessian[np.ix_(free, free)] / np.sqrt(np.outer(trust, trust))
        _, volume = np.linalg.slogdet(told + np.eye(len(trust)))
        return self.solved(kept)[1] + float(volume)

    def without_idle(self, kept: Sequence[int]) -> list[int]:
        """Return the effects for which there is evidence, those with the least gone first."""
        kept = list(kept)
        while kept:
            fewer = [self.priced([one for one in kept if one != index]) for index in kept]
            least = int(np.argmin(fewer))
            if fewer[least] > self.priced(kept) + SURE:
                break
            kept.pop(least)
        return kept

    def with_material(self, kept: Sequence[int]) -> list[int]:
        """Return the effects, and those beside them that take away a material share of the loss."""
        kept = list(kept)
        while left := [index for index in self.questioned if index not in kept]:
            more = [self.solved([*kept, index])[1] for index in left]
            best = int(np.argmin(more))
            if more[best] > (1.0 - MATERIAL) * self.solved(kept)[1]:
                break
            kept.append(left[best])
        return sorted(kept)

    def solved(self, kept: Sequence[int]) -> tuple[Array, float]:
        """Return the best change of the point with some of the effects, and its cost."""
        space, free = room(self.hypothesis, self.point), ~self._idle(kept)
        hessian, slope, loss = self._total
        # What says nothing goes to where it does; the rest makes the best of it.
        change = np.where(free, 0.0, np.nan_to_num(self.hypothesis.likely) - self.point)
        rest = Room(
            low=space.low[free],
            high=space.high[free],
            trust=space.trust[free],
            centre=space.centre[free],
        )
        change[free] = rest.best_change(
            hessian[np.ix_(free, free)], (slope - hessian @ change)[free], self.point[free]
        )
        left = loss + float(change @ hessian @ change - 2.0 * slope @ change)
        return change, max(left, 0.0) + space.price(self.point + change)

    @cached_property
    def _total(self) -> tuple[Array, Array, float]:
        """The quadratic of all segments together."""
        each = self.quadratic
        return each.hessian.sum(axis=0), each.slope.sum(axis=0), float(each.loss.sum())

    def _idle(self, kept: Sequence[int]) -> Mask:
        """Return which entries do nothing: effects left out, and figures that others say."""
        effects = self.hypothesis.effects
        used = [effects[index] for index in (*range(self.had), *kept)]
        said = [
            any(knob.part == each.where and knob.kind in each.stands_for for each in used)
            for knob in self.hypothesis.knobs
        ]
        left_out = [
            index >= self.had and index not in kept
            for index, each in enumerate(effects)
            for _ in each.free()
        ]
        return np.array(said + left_out, dtype=bool)
