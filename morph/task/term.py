"""One named term of a task's cost, and one goal of its success."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from morph.arrays import Array, Mask
from morph.errors import TaskError
from morph.task.moved import Moved
from morph.task.quantity import Quantity

Norm = Literal["quadratic", "saturating"]
"""How an error becomes a cost; `Term` has the formulas."""


@dataclass(frozen=True, kw_only=True)
class Term:
    """A part of the cost: how much it costs that a quantity is off its target.

    With e the error and w the width, `quadratic` costs |e|^2 / (2 w^2), and `saturating`
    1 - exp(-|e|^2 / (2 w^2)), which is nearly the same close to the target and never above 1.

    Source: Deisenroth and Rasmussen 2011, PILCO, ICML, section 2.2 (the saturating cost).
    """

    name: str
    """What it is called in reports."""
    quantity: Quantity
    """What it looks at."""
    target: tuple[float, ...]
    """Where the quantity should be, in its units."""
    width: float = 1.0
    """Error that costs about a half, in the quantity's unit."""
    weight: float = 1.0
    """What the rest is multiplied by."""
    norm: Norm = "quadratic"
    """`quadratic` or `saturating`."""
    last_only: bool = False
    """Whether only the last sample counts."""

    def __post_init__(self) -> None:
        """Check that every number is one."""
        if not all(math.isfinite(each) for each in (*self.target, self.weight)):
            self._refuse("its target or weight is no finite number", "give finite numbers")
        if not (math.isfinite(self.width) and self.width > 0.0 and self.weight >= 0.0):
            self._refuse(
                f"its width is {self.width:g} and its weight {self.weight:g}",
                "give a width above 0 and a weight of at least 0",
            )

    def _refuse(self, what: str, fix: str) -> None:
        raise TaskError(what, where=f"term {self.name}", fix=fix)

    def error(self, moved: Moved) -> Array:
        """Return how far the quantity is from its target, in widths, (..., samples, size)."""
        return self.quantity.error(moved, self.target) / self.width

    def cost(self, moved: Moved) -> Array:
        """Return what each sample costs, shape (..., samples)."""
        half = 0.5 * np.sum(self.error(moved) ** 2, axis=-1)
        cost = self.weight * (half if self.norm == "quadratic" else -np.expm1(-half))
        if self.last_only:
            cost[..., :-1] = 0.0
        return np.asarray(cost)


@dataclass(frozen=True, kw_only=True)
class Goal:
    """A part of success: a quantity near its target to the end, or beyond it at the end."""

    name: str
    """What it is called in reports."""
    quantity: Quantity
    """What it looks at."""
    target: tuple[float, ...]
    """Where the quantity should be, in its units."""
    within: float = math.inf
    """Farthest that any of its numbers may be from the target, in its unit."""
    beyond: bool = False
    """Whether every number must instead be at least the target."""
    last: float = 0.0
    """For how long to the end, s; 0 asks of the last sample alone."""

    def __post_init__(self) -> None:
        """Check that it asks for something."""
        if not all(math.isfinite(each) for each in self.target):
            raise TaskError(
                "its target is no finite number", where=f"goal {self.name}", fix="give finite ones"
            )
        if math.isinf(self.within) and not self.beyond:
            raise TaskError(
                "whatever happens reaches it",
                where=f"goal {self.name}",
                fix="say within which distance of the target, or that it is beyond it",
            )
        if not (self.within > 0.0 and self.last >= 0.0 and math.isfinite(self.last)):
            raise TaskError(
                f"it asks for {self.within:g} through the last {self.last:g} s",
                where=f"goal {self.name}",
                fix="give a distance above 0 and a time of at least 0 s",
            )

    def reached(self, moved: Moved) -> Mask:
        """Return which runs reach it, shape (...,)."""
        error = self.quantity.error(moved, self.target)
        fine = error >= 0.0 if self.beyond else np.abs(error) <= self.within
        # A sample that falls on the edge belongs to it, whatever rounding says.
        requested = moved.time >= moved.time[-1] - self.last - 1e-9
        return np.asarray(fine[..., requested, :].all(axis=(-2, -1)))
