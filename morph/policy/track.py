"""A trajectory with feedback: what should be seen at each time, and what is done if it is not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import PolicyError
from morph.policy.angles import marked, wrapped
from morph.policy.bound import Bound, bound_of
from morph.policy.policy import LARGEST, Action, Observation, Policy
from morph.policy.tensors import keep, named, place

MOST_KNOTS = 100_000
"""Most times of a trajectory."""

NAMES = ("nominal", "command", "gain", "angles")
"""The numbers of a trajectory with feedback."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Track(Policy):
    """u = clip(u_k + K_k (o - x_k)) at the k-th control period, differences of angles wrapped.

    After the last knot it holds that knot's observation, command and gain: a swing-up whose
    last knot is the goal, with the gain of an LQR, stays there. A nominal command at its bound
    would have half of its feedback clipped; `limits(action, margin)` gives a plan its room.
    """

    kind: ClassVar[str] = "track"

    nominal: Array
    """x, what should be seen at the start of each control period, shape (knots, observations)."""
    command: Array
    """u, what is commanded if it is, shape (knots, actions)."""
    gain: Array
    """K, what is added per difference, shape (knots, actions, observations)."""
    angles: Array | tuple[float, ...] = ()
    """1 for each observation that is an angle, rad, whose differences are wrapped to within half a
    turn, and 0 for each other, shape (observations,); empty if none is."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        super().__post_init__()
        keep(self, nominal=(None, self.size))
        if not self.size or len(self.nominal) > MOST_KNOTS:
            raise PolicyError(
                f"it observes {self.size} numbers at {len(self.nominal)} knots",
                where=place(self),
                fix=f"give observations, and at most {MOST_KNOTS} knots",
            )
        knots, actions = len(self.nominal), len(self.action)
        keep(self, command=(knots, actions), gain=(knots, actions, self.size))
        object.__setattr__(self, "angles", marked(self, self.angles))

    @cached_property
    def _turning(self) -> Integers:
        return np.flatnonzero(self.angles)

    @cached_property
    def limited(self) -> Bound:
        """What keeps its commands within their bounds."""
        return bound_of(self.action, "clip", where=place(self))

    def knot(self, time: Array) -> Integers:
        """Return the number of the knot that holds at each time, s, shape (...,)."""
        # A time may fall a rounding error before the knot that is due.
        at = np.floor(np.asarray(time, dtype=float) / self.period + 1e-6)
        return np.minimum(np.maximum(at, 0), len(self.nominal) - 1).astype(np.int64)

    def act(self, observation: Array, time: Array) -> Array:
        """Return the command of the knot that holds, corrected by what is seen."""
        seen = np.minimum(np.maximum(np.asarray(observation, dtype=float), -LARGEST), LARGEST)
        knot = self.knot(time)
        first = int(knot.flat[0]) if knot.size else 0
        if (knot == first).all():
            # One clock for all: a product of matrices.
            away = wrapped(seen - self.nominal[first], self._turning)
            command = away @ self.gain[first].T + self.command[first]
        else:
            away = wrapped(seen - self.nominal[knot], self._turning)
            command = (self.gain[knot] @ away[..., None])[..., 0] + self.command[knot]
        return self.limited(command)

    def typical(self, time: Array, rng: np.random.Generator) -> Array:
        """Return observations near what should be seen."""
        return np.asarray(self.nominal[self.knot(time)] + super().typical(time, rng))

    def weights(self) -> Mapping[str, Array]:
        """Return the nominal observations and commands, the gains, and which are angles."""
        return {name: np.asarray(getattr(self, name)) for name in NAMES}

    @classmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Track:
        """Return the trajectory with feedback that these numbers make."""
        named(weights, NAMES, cls.kind)
        return cls(
            nominal=weights["nominal"],
            command=weights["command"],
            gain=weights["gain"],
            angles=weights["angles"],
            action=action,
            period=period,
            observation=observation,
        )
