"""A small network: layers of tanh, and a linear last one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import PolicyError
from morph.policy.feedback import SHARED, Feedback, bound_named
from morph.policy.policy import Action, Observation
from morph.policy.tensors import kept, named, place

MOST_LAYERS = 16
"""Most layers of a network, the last included."""

WIDEST = 10_000
"""Most outputs of a layer."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Network(Feedback):
    """u = bounded(W_n h_n-1 + b_n), h_i = tanh(W_i h_i-1 + b_i), h_0 being the features."""

    kind: ClassVar[str] = "network"

    layers: tuple[tuple[Array, Array], ...]
    """W, shape (outputs, inputs), and b, shape (outputs,), of each layer; the last has one output
    for each action."""

    def __post_init__(self) -> None:
        """Check that each layer takes what the one before it gives."""
        super().__post_init__()
        if not 1 <= len(self.layers) <= MOST_LAYERS:
            raise PolicyError(
                f"it has {len(self.layers)} layers",
                where=place(self),
                fix=f"give 1 to {MOST_LAYERS} layers",
            )
        checked: list[tuple[Array, Array]] = []
        inputs = self.inputs
        for at, (weight, bias) in enumerate(self.layers):
            last = at == len(self.layers) - 1
            outputs = len(self.action) if last else None
            name = f"layer.{at}"
            W = kept(weight, f"{name}.weight", (outputs, inputs), where=place(self))
            b = kept(bias, f"{name}.bias", (len(W),), where=place(self))
            checked.append((W, b))
            inputs = len(W)
            if inputs > WIDEST:
                raise PolicyError(
                    f"{name} has {inputs} outputs", where=place(self), fix=f"give at most {WIDEST}"
                )
        object.__setattr__(self, "layers", tuple(checked))

    def raw(self, features: Array) -> Array:
        """Return the last layer's output."""
        x = features
        for weight, bias in self.layers[:-1]:
            x = x @ weight.T
            x += bias
            np.tanh(x, out=x)
        weight, bias = self.layers[-1]
        return np.asarray(x @ weight.T + bias)

    def weights(self) -> Mapping[str, Array]:
        """Return `layer.0.weight`, `layer.0.bias` and so on, and what every feedback has."""
        results: dict[str, Array] = {}
        for at, (weight, bias) in enumerate(self.layers):
            results |= {f"layer.{at}.weight": weight, f"layer.{at}.bias": bias}
        return {**results, **self.shared()}

    @classmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Network:
        """Return the network that these numbers make."""
        # No more layers are named in an error than a network may have.
        count = min(sum(name.endswith(".weight") for name in weights), MOST_LAYERS)
        pairs = [(f"layer.{at}.weight", f"layer.{at}.bias") for at in range(max(count, 1))]
        named(weights, (*(name for pair in pairs for name in pair), *SHARED), cls.kind)
        return cls(
            layers=tuple((weights[weight], weights[bias]) for weight, bias in pairs),
            angles=weights["angles"],
            bound=bound_named(weights, cls.kind),
            action=action,
            period=period,
            observation=observation,
        )
