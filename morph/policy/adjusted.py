"""A policy made elsewhere, and what is added so that it does on a body what it did there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import PolicyError
from morph.policy.angles import features, marked
from morph.policy.bound import Bound, bound_of
from morph.policy.linear import Linear
from morph.policy.network import Network
from morph.policy.pattern import Pattern
from morph.policy.policy import LARGEST, Action, Observation, Policy
from morph.policy.radial import MOST_UNITS, THINNEST, Radial
from morph.policy.tensors import keep, named, place
from morph.policy.track import Track

SOURCES: tuple[type[Policy], ...] = (Pattern, Linear, Radial, Network, Track)
"""Kinds of policies that can be adjusted; an adjustment of an adjusted one is made anew."""

NAMES = ("angles", "bias", "law", "centre", "width", "weight", "reach")
"""The numbers of the adjustment; the source's stand beside them, behind the name of its kind."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Adjusted(Policy):
    """u = clip(v + b + W z + sum over i of w_i exp(-|(z - c_i) / s|^2 / 2)), z = (f(o), v).

    v is what the source's policy commands and f(o) are features, as in `Feedback`, of the newest
    that is seen of each channel. In the law W z numbers beyond their reach count as their reach;
    the radial functions fade out by themselves. `morph.alignment.adjust` finds these numbers.

    Source: Gamboa Higuera 2015, section 3.3, where it is called pi_adj.
    """

    kind: ClassVar[str] = "adjusted"

    source: Policy
    """What is adjusted: it sees the same, or nothing."""
    bias: Array
    """b, shape (actions,)."""
    law: Array
    """W, shape (actions, features + actions)."""
    centre: Array
    """c, shape (units, features + actions)."""
    width: Array
    """s, for each action its own, shape (actions, features + actions)."""
    weight: Array
    """w, shape (actions, units)."""
    reach: Array
    """Greatest size of each number that the law is taken to hold for, (features + actions,)."""
    angles: Array | tuple[float, ...] = ()
    """1 for each number that is an angle, rad, to be seen by its sine and cosine, and 0 for each
    other, shape (observations,); empty if none is."""

    def __post_init__(self) -> None:
        """Check that the source fits, and the shapes."""
        super().__post_init__()
        mine, its = (self.action, self.period), (self.source.action, self.source.period)
        sees = self.source.observation in ((), self.observation)
        if type(self.source) not in SOURCES or mine != its or not sees or not self.size:
            raise PolicyError(
                f"what it adjusts is of kind {self.source.kind}, or commands or sees otherwise",
                where=place(self),
                fix=f"give one of {', '.join(kind.kind for kind in SOURCES)}, with the same "
                "actions, period and observations",
            )
        object.__setattr__(self, "angles", marked(self, self.angles))
        plain, turned = self.seen
        actions = len(self.action)
        inputs = len(plain) + 2 * len(turned) + actions
        keep(self, bias=(actions,), law=(actions, inputs), centre=(None, inputs))
        keep(self, width=(actions, inputs), reach=(inputs,))
        keep(self, weight=(actions, len(self.centre)))
        if len(self.centre) > MOST_UNITS:
            raise PolicyError(
                f"it has {len(self.centre)} radial functions",
                where=place(self),
                fix=f"give at most {MOST_UNITS}",
            )
        if not ((self.width >= THINNEST).all() and (self.reach >= 0.0).all()):
            raise PolicyError(
                "a width or a reach is too small",
                where=place(self),
                fix=f"give widths of at least {THINNEST:g}, and reaches of at least 0",
            )

    @cached_property
    def newest(self) -> Integers:
        """Which of the numbers that are seen are the newest of their channel."""
        return newest(self.observation)

    @cached_property
    def seen(self) -> tuple[Integers, Integers]:
        """Which of the newest numbers are no angles, and which are."""
        angle = np.asarray(self.angles, dtype=bool)[self.newest]
        return np.flatnonzero(~angle), np.flatnonzero(angle)

    @cached_property
    def limited(self) -> Bound:
        """What keeps its commands within their bounds."""
        return bound_of(self.action, "clip", where=place(self))

    @cached_property
    def scaled(self) -> tuple[Array, tuple[tuple[Array, Array], ...]]:
        """The centres' middle; for each action centres about it in widths, and half squares."""
        middle = self.centre.mean(axis=0)
        each = [(self.centre - middle) / width for width in self.width]
        return middle, tuple((centre, 0.5 * np.square(centre).sum(axis=1)) for centre in each)

    def act(self, observation: Array, time: Array) -> Array:
        """Return the source's command and what is added to it, within bounds."""
        seen = np.asarray(observation, dtype=float)
        command = self.source.act(seen[..., : self.source.size], time)
        return self.limited(command + self.added(seen, command))

    def added(self, observation: Array, command: Array) -> Array:
        """Return what is added to commands of the source, shape (..., actions)."""
        now = features(observation[..., self.newest], *self.seen)
        z = np.concatenate([now, command], axis=-1)
        result = np.minimum(np.maximum(z, -self.reach), self.reach) @ self.law.T + self.bias
        middle, parts = self.scaled
        for at, (centre, half) in enumerate(parts):
            # As in `Radial`: the square of a difference as a product of matrices.
            x = np.minimum(np.maximum((z - middle) / self.width[at], -LARGEST), LARGEST)
            power = x @ centre.T
            power -= half
            power -= 0.5 * np.square(x).sum(axis=-1, keepdims=True)
            np.minimum(power, 0.0, out=power)
            result[..., at] += np.exp(power, out=power) @ self.weight[at]
        return np.asarray(result)

    def typical(self, time: Array, rng: np.random.Generator) -> Array:
        """Return observations that its source may meet."""
        if self.source.size:
            return self.source.typical(time, rng)
        return super().typical(time, rng)

    def weights(self) -> Mapping[str, Array]:
        """Return the numbers of the adjustment, and the source's behind its kind."""
        own = {name: np.asarray(getattr(self, name)) for name in NAMES}
        its = self.source.weights().items()
        return {**own, **{f"{self.source.kind}.{name}": value for name, value in its}}

    @classmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Adjusted:
        """Return the adjusted policy that these numbers make."""
        names = {name.partition(".")[0] for name in weights.keys() - set(NAMES)}
        known = {kind.kind: kind for kind in SOURCES}
        kinds = sorted(names & known.keys())
        whose = f"{kinds[0]}." if kinds else "track."
        its = {name: value for name, value in weights.items() if name.startswith(whose)}
        named({n: weights[n] for n in weights.keys() - its.keys()}, NAMES, cls.kind)
        kind = known[whose[:-1]]
        source = kind.of(
            {name.removeprefix(whose): value for name, value in its.items()},
            action=action,
            period=period,
            observation=() if kind is Pattern else observation,
        )
        return cls(
            source=source,
            action=action,
            period=period,
            observation=observation,
            **{name: weights[name] for name in NAMES},
        )


def newest(observation: tuple[Observation, ...]) -> Integers:
    """Return which of the numbers that are seen are the newest of their channel."""
    counts = [0, *(each.history for each in observation)]
    return np.cumsum(counts)[:-1].astype(np.int64)
