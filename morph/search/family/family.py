"""Families of policies that a few numbers single out, for searches that only try."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.policy.policy import Policy


@dataclass(frozen=True, kw_only=True)
class Number:
    """One number that a search may choose."""

    name: str
    """What it is called in reports."""
    low: float
    """The least value that is tried."""
    high: float
    """The greatest."""
    start: float
    """Where a search begins."""

    def __post_init__(self) -> None:
        """Check that the start lies within the bounds."""
        finite = all(math.isfinite(each) for each in (self.low, self.high))
        if not (finite and self.low < self.high and self.low <= self.start <= self.high):
            raise SearchError(
                f"it begins at {self.start:g} within {self.low:g} and {self.high:g}",
                where=f"free number {self.name!r}",
                fix="give finite bounds, the lesser first, and a start within them",
            )


@dataclass(frozen=True, kw_only=True)
class Family(ABC):
    """Policies of one form; a point of the unit cube makes one of them.

    A search sees the cube alone, where every side is as long as any other.
    """

    numbers: tuple[Number, ...]
    """What is free, one side of the cube each."""
    sigma: float = 0.25
    """How far from its start a search reaches at first, in sides of the cube."""

    @abstractmethod
    def make(self, values: Array) -> Policy:
        """Return the policy that these values make, in the numbers' own units, shape (numbers,)."""

    @property
    def start(self) -> Array:
        """Where in the cube a search begins, shape (numbers,)."""
        return np.array([(n.start - n.low) / (n.high - n.low) for n in self.numbers])

    def values(self, point: Array) -> Array:
        """Return the values at a point of the cube; beyond a face the face counts."""
        low, high = (np.array([getattr(n, end) for n in self.numbers]) for end in ("low", "high"))
        return np.asarray(low + (high - low) * np.clip(point, 0.0, 1.0))

    def policy(self, point: Array) -> Policy:
        """Return the policy at a point of the cube, shape (numbers,)."""
        return self.make(self.values(point))
