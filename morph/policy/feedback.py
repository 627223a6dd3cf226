"""What policies share that command a function of what they see: features, and bounds."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import PolicyError
from morph.policy.angles import features, marked
from morph.policy.bound import SQUASHES, Bound, bound_of
from morph.policy.policy import Policy
from morph.policy.tensors import kept, place

SHARED = ("angles", "bound")
"""Names of the numbers that every such policy has."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Feedback(Policy):
    """A policy that commands a function of features of what it sees.

    The features are the observations that are no angles, in their order; then of each angle
    its sine and its cosine, so that a pole that has gone round once more is where it was.
    """

    angles: Array | tuple[float, ...] = ()
    """1 for each number that is an angle, rad, to be seen by its sine and cosine, and 0 for each
    other, shape (observations,); empty if none is."""
    bound: str = "clip"
    """How commands are kept within their bounds: `clip`, `sine` or `tanh`. Clipped, the function
    is in the unit of the command; squashed, in halves of its range, from the range's middle."""

    def __post_init__(self) -> None:
        """Check what is observed, which of it are angles, and the bound."""
        super().__post_init__()
        if not self.observation:
            raise PolicyError(
                "it observes nothing",
                where=place(self),
                fix="give observations, for example observations_of(robot)",
            )
        object.__setattr__(self, "angles", marked(self, self.angles))
        bound_of(self.action, self.bound, where=place(self))

    @cached_property
    def seen(self) -> tuple[Integers, Integers]:
        """Which numbers are no angles, and which are."""
        angle = np.asarray(self.angles, dtype=bool)
        return np.flatnonzero(~angle), np.flatnonzero(angle)

    @cached_property
    def limited(self) -> Bound:
        """What keeps its commands within their bounds."""
        return bound_of(self.action, self.bound, where=place(self))

    @property
    def inputs(self) -> int:
        """How many features there are."""
        plain, angles = self.seen
        return len(plain) + 2 * len(angles)

    def features(self, observation: Array) -> Array:
        """Return what the function is of, shape (..., features)."""
        return features(np.asarray(observation, dtype=float), *self.seen)

    @abstractmethod
    def raw(self, features: Array) -> Array:
        """Return the function before it is bounded, shape (..., actions)."""

    def act(self, observation: Array, time: Array) -> Array:
        """Return the function, bounded; it does not look at the clock."""
        return self.limited(self.raw(self.features(observation)))

    def shared(self) -> dict[str, Array]:
        """Return the numbers of `SHARED`."""
        how = float(list(SQUASHES).index(self.bound))
        return {"angles": np.asarray(self.angles), "bound": np.array(how)}


def bound_named(weights: Mapping[str, Array], kind: str) -> str:
    """Return the name of the bound whose number is stored.

    Raises:
        PolicyError: No bound has that number.
    """
    where = f"a policy of kind {kind}"
    number = float(kept(weights["bound"], "bound", (), where=where))
    names = dict(enumerate(SQUASHES))
    if number not in names:
        known = ", ".join(f"{each} ({name})" for each, name in names.items())
        raise PolicyError(f"its bound is {number:g}", where=where, fix=f"use one of {known}")
    return names[int(number)]
