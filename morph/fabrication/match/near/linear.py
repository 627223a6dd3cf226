"""Linear policies near a linear policy: softer or stiffer, with more damping, shifted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.fabrication.match.near.roles import ranges_of, roles_of
from morph.policy.linear import Linear
from morph.search.family.family import Family, Number
from morph.search.family.parts import parts_of

STIFFER, SHIFTED = 0.7, 0.1
"""Farthest change of gains as a share of themselves, and of a constant in ranges."""


@dataclass(frozen=True, kw_only=True)
class NearLinear(Family):
    """Policies u = bounded(W' f + b'), gains of one role on one kind of reading scaled alike."""

    linear: Linear
    """The policy that they are near."""

    def make(self, values: Array) -> Linear:
        """Return the policy of these values."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        roles, seen = roles_of(self.linear.action), seen_of(self.linear)
        scale = np.array([1.0 + free.get(f"gain on {kind}", 0.0) for kind in seen])
        shift = np.array([free[f"{role} shift"] for role in roles])
        if self.linear.bound != "clip":
            # Squashed, the function is in halves of the range.
            shift = 2.0 * shift / ranges_of(self.linear.action)
        return replace(
            self.linear, weight=self.linear.weight * scale, bias=self.linear.bias + shift
        )


def near_linear(linear: Linear, sigma: float) -> NearLinear:
    """Return the linear policies near one.

    Args:
        linear: The policy.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    roles, ranges = roles_of(linear.action), ranges_of(linear.action)
    numbers = [
        Number(name=f"gain on {kind}", low=-STIFFER, high=STIFFER, start=0.0)
        for kind in dict.fromkeys(seen_of(linear))
    ]
    for role in dict.fromkeys(roles):
        wide = SHIFTED * min(float(r) for r, own in zip(ranges, roles, strict=True) if own == role)
        numbers.append(Number(name=f"{role} shift", low=-wide, high=wide, start=0.0))
    return NearLinear(linear=linear, numbers=tuple(numbers), sigma=sigma)


def seen_of(linear: Linear) -> tuple[str, ...]:
    """Return what kind of reading each feature is: role and quantity, such as `knee velocity`."""
    channels = [each.channel for each in linear.observation for _ in range(each.history)]
    split = [channel.partition(".") for channel in channels]
    parts = parts_of(tuple(part for part, _, _ in split))
    kinds = [
        f"{part.role or name} {quantity}"
        for part, (name, _, quantity) in zip(parts, split, strict=True)
    ]
    plain, angles = linear.seen
    # Of each angle its sine and its cosine.
    return (*(kinds[at] for at in plain), *(kinds[at] for at in angles for _ in range(2)))
