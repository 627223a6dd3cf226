"""Linear policies near a linear policy: softer or stiffer, with more damping, shifted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.roles import Role, actuator_roles, joint_roles
from morph.fabrication.match.near.ranges import narrowest_of, ranges_of
from morph.policy.linear import Linear
from morph.search.family.family import Family, Number

STIFFER, SHIFTED = 0.7, 0.1
"""Farthest change of gains as a share of themselves, and of a constant in ranges."""


@dataclass(frozen=True, kw_only=True)
class NearLinear(Family):
    """Policies u = bounded(W' f + b'), gains of one role on one kind of reading scaled alike."""

    linear: Linear
    """The policy that they are near."""
    roles: tuple[Role, ...]
    """The role of each actuator."""
    seen: tuple[str, ...]
    """What kind of reading each feature is."""

    def make(self, values: Array) -> Linear:
        """Return the policy of these values."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        scale = np.array([1.0 + free.get(f"gain on {kind}", 0.0) for kind in self.seen])
        shift = np.array([role.sense * free[f"{role.name} shift"] for role in self.roles])
        if self.linear.bound != "clip":
            # Squashed, the function is in halves of the range.
            shift = 2.0 * shift / ranges_of(self.linear.action)
        return replace(
            self.linear, weight=self.linear.weight * scale, bias=self.linear.bias + shift
        )


def near_linear(linear: Linear, robot: Robot, sigma: float) -> NearLinear:
    """Return the linear policies near one.

    Args:
        linear: The policy.
        robot: The body that it commands.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    known, seen = actuator_roles(robot), seen_of(linear, robot)
    roles = tuple(known[each.actuator] for each in linear.action)
    numbers = [
        Number(name=f"gain on {kind}", low=-STIFFER, high=STIFFER, start=0.0)
        for kind in dict.fromkeys(seen)
    ]
    for name, narrowest in narrowest_of(roles, linear.action).items():
        wide = SHIFTED * narrowest
        numbers.append(Number(name=f"{name} shift", low=-wide, high=wide, start=0.0))
    return NearLinear(linear=linear, roles=roles, seen=seen, numbers=tuple(numbers), sigma=sigma)


def seen_of(linear: Linear, robot: Robot) -> tuple[str, ...]:
    """Return what kind of reading each feature is: role and quantity, such as `knee velocity`."""
    channels = [each.channel for each in linear.observation for _ in range(each.history)]
    roles = {name: role.name for name, role in joint_roles(robot).items()}
    split = [channel.partition(".") for channel in channels]
    kinds = [f"{roles.get(part, part)} {quantity}" for part, _, quantity in split]
    plain, angles = linear.seen
    # Of each angle its sine and its cosine.
    return (*(kinds[at] for at in plain), *(kinds[at] for at in angles for _ in range(2)))
