"""Affine maps of states and commands: what most learned maps are near a state of rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError
from morph.alignment.maps.body_map import BodyMap

SHAPES = {
    "state_law": 2, "state_shift": 1, "lift_law": 2, "lift_shift": 1, "action_law": 2,
    "action_state": 2, "action_shift": 1, "read_law": 2, "read_state": 2, "read_shift": 1,
}  # fmt: skip
"""Names of the numbers, and how many axes each has."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AffineMap(BodyMap):
    """x = S y + s, y = L x + l, a = W u + E y + w, u = R a + F y + r, in this order.

    x and u are the source's, y and a the target's. A command may depend on the target's state:
    what a servo is told includes where its joint is.
    """

    kind: ClassVar[str] = "affine"

    state_law: Array
    """S, shape (n_s, n_t)."""
    state_shift: Array
    """s, shape (n_s,)."""
    lift_law: Array
    """L, shape (n_t, n_s)."""
    lift_shift: Array
    """l, shape (n_t,)."""
    action_law: Array
    """W, shape (k_t, k_s)."""
    action_state: Array
    """E, shape (k_t, n_t)."""
    action_shift: Array
    """w, shape (k_t,)."""
    read_law: Array
    """R, shape (k_s, k_t)."""
    read_state: Array
    """F, shape (k_s, n_t)."""
    read_shift: Array
    """r, shape (k_s,)."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        (n_s, n_t), (k_t, k_s) = self.state_law.shape, self.action_law.shape
        fit = {
            "state_law": (n_s, n_t), "state_shift": (n_s,), "lift_law": (n_t, n_s),
            "lift_shift": (n_t,), "action_law": (k_t, k_s), "action_state": (k_t, n_t),
            "action_shift": (k_t,), "read_law": (k_s, k_t), "read_state": (k_s, n_t),
            "read_shift": (k_s,),
        }  # fmt: skip
        for name, shape in fit.items():
            result = getattr(self, name)
            if result.shape != shape or not np.isfinite(result).all():
                raise MapError(
                    f"{name} has the shape {result.shape}, or a number of it is not finite",
                    where="an affine map",
                    fix=f"give finite numbers of the shape {shape}",
                )

    def state(self, target: Array) -> Array:
        """Return S y + s."""
        return np.asarray(target @ self.state_law.T + self.state_shift)

    def state_back(self, source: Array) -> Array:
        """Return L x + l."""
        return np.asarray(source @ self.lift_law.T + self.lift_shift)

    def action(self, target: Array, command: Array) -> Array:
        """Return W u + E y + w."""
        law = command @ self.action_law.T + target @ self.action_state.T
        return np.asarray(law + self.action_shift)

    def action_back(self, target: Array, command: Array) -> Array:
        """Return R a + F y + r."""
        return np.asarray(command @ self.read_law.T + target @ self.read_state.T + self.read_shift)

    def weights(self) -> Mapping[str, Array]:
        """Return all ten arrays."""
        return {name: getattr(self, name) for name in SHAPES}

    @classmethod
    def of(cls, weights: Mapping[str, Array]) -> AffineMap:
        """Return the affine map that these numbers make."""
        wrong = set(SHAPES) ^ set(weights)
        axes = {
            name
            for name, count in SHAPES.items()
            if name in weights and np.ndim(weights[name]) != count
        }
        if wrong or axes:
            raise MapError(
                f"{', '.join(sorted(wrong | axes))} is missing, unknown or misshapen",
                where="an affine map",
                fix=f"give {', '.join(SHAPES)}",
            )
        return cls(**{name: np.asarray(weights[name], dtype=float) for name in SHAPES})
