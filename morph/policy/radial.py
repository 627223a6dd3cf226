"""A policy of radial basis functions: each says what to do near one state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import PolicyError
from morph.policy.feedback import SHARED, Feedback, bound_named
from morph.policy.policy import LARGEST, Action, Observation
from morph.policy.tensors import keep, named, place

MOST_UNITS = 10_000
"""Most basis functions."""

THINNEST = 1e-6
"""Least width of a basis function."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Radial(Feedback):
    """u = bounded(sum over i of w_i exp(-|(f(o) - c_i) / s|^2 / 2)), f being the features.

    Source: Deisenroth and Rasmussen 2011, PILCO, ICML, eq. 9, with the same widths for all.
    """

    kind: ClassVar[str] = "radial"

    centre: Array
    """c, shape (units, features)."""
    width: Array
    """s, in the features' units, shape (features,)."""
    weight: Array
    """w, shape (actions, units)."""

    def __post_init__(self) -> None:
        """Check the shapes and the widths."""
        super().__post_init__()
        keep(self, centre=(None, self.inputs), width=(self.inputs,))
        keep(self, weight=(len(self.action), len(self.centre)))
        if len(self.centre) > MOST_UNITS:
            raise PolicyError(
                f"it has {len(self.centre)} basis functions",
                where=place(self),
                fix=f"give at most {MOST_UNITS}",
            )
        if not (self.width >= THINNEST).all():
            raise PolicyError(
                f"a width of {self.width.min():g} is too small",
                where=place(self),
                fix=f"give widths of at least {THINNEST:g}",
            )

    @cached_property
    def scaled(self) -> tuple[Array, Array, Array]:
        """A middle of the centres, the centres about it in widths, and half their squares."""
        middle = self.centre.mean(axis=0)
        centre = (self.centre - middle) / self.width
        return middle, centre, 0.5 * np.square(centre).sum(axis=1)

    def raw(self, features: Array) -> Array:
        """Return the weighted sum of the basis functions."""
        middle, centre, half = self.scaled
        # |a - c|^2 = |a|^2 + |c|^2 - 2 a c is one product of matrices. Far off it would be a
        # difference of great numbers: there the function is 0 anyway.
        x = np.minimum(np.maximum((features - middle) / self.width, -LARGEST), LARGEST)
        power = x @ centre.T
        power -= half
        power -= 0.5 * np.square(x).sum(axis=-1, keepdims=True)
        np.minimum(power, 0.0, out=power)
        return np.asarray(np.exp(power, out=power) @ self.weight.T)

    def typical(self, time: Array, rng: np.random.Generator) -> Array:
        """Return observations among the centres, where the functions are felt."""
        plain, angles = self.seen
        near = self.centre[rng.integers(len(self.centre), size=len(time))]
        near = near + self.width * rng.normal(size=near.shape)
        result = np.empty((len(time), self.size))
        result[:, plain] = near[:, : len(plain)]
        sine, cosine = near[:, len(plain) :: 2], near[:, len(plain) + 1 :: 2]
        result[:, angles] = np.arctan2(sine, cosine)
        return result

    def weights(self) -> Mapping[str, Array]:
        """Return centres, widths, weights, and what every policy with feedback has."""
        own = {"centre": self.centre, "width": self.width, "weight": self.weight}
        return {**own, **self.shared()}

    @classmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Radial:
        """Return the policy of radial basis functions that these numbers make."""
        named(weights, ("centre", "width", "weight", *SHARED), cls.kind)
        return cls(
            centre=weights["centre"],
            width=weights["width"],
            weight=weights["weight"],
            angles=weights["angles"],
            bound=bound_named(weights, cls.kind),
            action=action,
            period=period,
            observation=observation,
        )
