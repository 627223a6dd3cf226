"""A linear policy: commands are a matrix times what is seen, and a constant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.policy.feedback import SHARED, Feedback, bound_named
from morph.policy.policy import Action, Observation
from morph.policy.tensors import keep, named


@dataclass(frozen=True, kw_only=True, eq=False)
class Linear(Feedback):
    """u = bounded(W f(o) + b), f being the features of what is seen.

    A law u = -K (o - o0) about a state o0 has W = -K and b = K o0.
    """

    kind: ClassVar[str] = "linear"

    weight: Array
    """W, shape (actions, features)."""
    bias: Array
    """b, shape (actions,)."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        super().__post_init__()
        keep(self, weight=(len(self.action), self.inputs), bias=(len(self.action),))

    def raw(self, features: Array) -> Array:
        """Return W f + b."""
        return np.asarray(features @ self.weight.T + self.bias)

    def weights(self) -> Mapping[str, Array]:
        """Return W, b and what every policy with feedback has."""
        return {"weight": self.weight, "bias": self.bias, **self.shared()}

    @classmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Linear:
        """Return the linear policy that these numbers make."""
        named(weights, ("weight", "bias", *SHARED), cls.kind)
        return cls(
            weight=weights["weight"],
            bias=weights["bias"],
            angles=weights["angles"],
            bound=bound_named(weights, cls.kind),
            action=action,
            period=period,
            observation=observation,
        )
