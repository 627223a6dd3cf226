"""Maps that straighten a target's numbers first: curves or a small network, then affine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError
from morph.alignment.maps.affine_map import SHAPES, AffineMap
from morph.alignment.maps.body_map import BodyMap
from morph.alignment.maps.feature_warping import InvertibleWarp, straight_of

ABOUT = ("middle", "spread", "command_middle", "command_spread")
"""Names of what the target's numbers are moved and divided by."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BentMap(BodyMap):
    """x = S z(t) + s with t = (y - middle) / spread, and commands likewise.

    Both straightened ways have inverses everywhere, so that the map has one where the affine
    part has.
    """

    kind: ClassVar[str] = "bent"

    affine: AffineMap
    """From straightened numbers of the target to the source's, both ways."""
    states: InvertibleWarp
    """z of the states."""
    commands: InvertibleWarp
    """z of the commands."""
    middle: Array
    """Of the target's states, shape (n_t,)."""
    spread: Array
    """Positive, shape (n_t,)."""
    command_middle: Array
    """Of the target's commands, shape (k_t,)."""
    command_spread: Array
    """Positive, shape (k_t,)."""

    def __post_init__(self) -> None:
        """Check that the parts fit each other."""
        n, k = len(self.affine.lift_shift), len(self.affine.action_shift)
        shapes = [part.shape for part in (self.middle, self.spread)]
        command_shapes = [part.shape for part in (self.command_middle, self.command_spread)]
        fit = shapes == [(n,)] * 2 and command_shapes == [(k,)] * 2
        fit = fit and self.states.size == n and self.commands.size == k
        if not fit or not (self.spread.min() > 0.0 and self.command_spread.min() > 0.0):
            raise MapError(
                f"middles and spreads have the shapes {[*shapes, *command_shapes]}, or a spread is "
                f"not positive, where the affine part has {n} states and {k} commands",
                where="a bent map",
                fix="give all parts for the same numbers of the target",
            )

    def state(self, target: Array) -> Array:
        """Return S z(t) + s."""
        return self.affine.state(self._straight(target))

    def state_back(self, source: Array) -> Array:
        """Return the target's states that straighten to L x + l."""
        z = self.affine.state_back(source)
        return np.asarray(self.middle + self.spread * self.states.back(z))

    def action(self, target: Array, command: Array) -> Array:
        """Return the target's commands that straighten to W u + E z + w."""
        z = self.affine.action(self._straight(target), command)
        return np.asarray(self.command_middle + self.command_spread * self.commands.back(z))

    def action_back(self, target: Array, command: Array) -> Array:
        """Return R z_a + F z + r."""
        commanded = self.commands.value((command - self.command_middle) / self.command_spread)
        return self.affine.action_back(self._straight(target), commanded)

    def weights(self) -> Mapping[str, Array]:
        """Return all numbers, those of a part after its name."""
        results = {f"affine.{name}": value for name, value in self.affine.weights().items()}
        for part in ("states", "commands"):
            results |= {f"{part}.{name}": v for name, v in getattr(self, part).weights().items()}
        return results | {name: getattr(self, name) for name in ABOUT}

    @classmethod
    def of(cls, weights: Mapping[str, Array]) -> BentMap:
        """Return the bent map that these numbers make."""
        parts: dict[str, dict[str, Array]] = {"affine": {}, "states": {}, "commands": {}, "": {}}
        for name, value in weights.items():
            part, _, rest = name.rpartition(".")
            parts.setdefault(part, {})[rest] = np.asarray(value, dtype=float)
        wrong = sorted(set(parts) - {"affine", "states", "commands", ""})
        if wrong or set(parts[""]) != set(ABOUT) or set(parts["affine"]) != set(SHAPES):
            raise MapError(
                f"it has the parts {', '.join(sorted(weights))}",
                where="a bent map",
                fix=f"give {', '.join(ABOUT)}, and affine., states. and commands. with theirs",
            )
        return cls(
            affine=AffineMap.of(parts["affine"]),
            states=straight_of(parts["states"]),
            commands=straight_of(parts["commands"]),
            **parts[""],
        )

    def _straight(self, target: Array) -> Array:
        return self.states.value((target - self.middle) / self.spread)
