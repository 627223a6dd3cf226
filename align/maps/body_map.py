"""What a map between two bodies is, and what learns one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError
from morph.alignment.samples import Pairs, Step, Transitions, Worth


class BodyMap(ABC):
    """How a target's states are seen as a source's, and the source's commands become the target's.

    A policy pi of the source moves the target by action(y, pi(state(y))) at each state y.

    Source: Ammar, Eaton, Ruvolo and Taylor 2015, AAAI (inter-task maps of states, both ways).
    """

    kind: ClassVar[str]
    """What files call it."""

    @abstractmethod
    def state(self, target: Array) -> Array:
        """Return what the target's states (m, n_t) are to the source, shape (m, n_s)."""

    @abstractmethod
    def state_back(self, source: Array) -> Array:
        """Return states of the target (m, n_t) that are these of the source, shape (m, n_s).

        state(state_back(x)) is x, as far as the target can be in such a state.
        """

    @abstractmethod
    def action(self, target: Array, command: Array) -> Array:
        """Return what to tell the target, (m, k_t), for a command of the source, (m, k_s).

        Args:
            target: States of the target, shape (m, n_t).
            command: What the source would be told there.
        """

    @abstractmethod
    def action_back(self, target: Array, command: Array) -> Array:
        """Return what commands of the target (m, k_t) at its states are to the source, (m, k_s)."""

    @abstractmethod
    def weights(self) -> Mapping[str, Array]:
        """Return all its numbers by name, as a file `map.npz` holds them."""

    @classmethod
    @abstractmethod
    def of(cls, weights: Mapping[str, Array]) -> BodyMap:
        """Return the map that these numbers make.

        Raises:
            MapError: A number is missing or more than that, or the shapes do not fit.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class MapData:
    """What a map is learned from; each mapper says in `needs` what it cannot do without."""

    source: Transitions
    """What the source did."""
    target: Transitions
    """What the target did."""
    pairs: Pairs | None = None
    """A few states of both that correspond."""
    step: Step | None = None
    """The source's simulator, over the control period of the transitions."""
    source_worth: Worth | None = None
    """What the source's states cost by the task."""
    target_worth: Worth | None = None
    """What the target's states cost by the same task."""


@dataclass(frozen=True, kw_only=True)
class Mapper(ABC):
    """A way to learn a map; its fields are its settings, listed in `align/maps/maps.py`."""

    name: ClassVar[str]
    """What studies and commands call it."""
    needs: ClassVar[frozenset[str]] = frozenset()
    """Which of `pairs`, `step`, `source_worth` and `target_worth` it cannot do without."""

    def fit(self, given: MapData, rng: np.random.Generator) -> BodyMap:
        """Return the map that the data make most likely.

        Raises:
            MapError: What it needs is missing, or no map that can be inverted is found.
            SamplesError: The data are too few, or excite too little.
        """
        missing = sorted(need for need in self.needs if getattr(given, need) is None)
        if missing:
            raise MapError(
                f"it is not given {', '.join(missing)}",
                where=f"map {self.name}",
                fix="give what it needs, or take a map that does without",
            )
        return self.estimate(given, rng)

    @abstractmethod
    def estimate(self, given: MapData, rng: np.random.Generator) -> BodyMap:
        """Return what `fit` is to give back; what it needs is there."""
