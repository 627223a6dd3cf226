"""Policies near any policy that observes: its commands a little stronger, and shifted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.roles import Role, actuator_roles
from morph.fabrication.match.near.ranges import narrowest_of
from morph.policy.adjusted import SOURCES, Adjusted, newest
from morph.policy.policy import LARGEST, Policy
from morph.search.family.family import Family, Number

STRONGER, SHIFTED = 0.6, 0.1
"""Farthest change of commands as a share of themselves, and of their shift in ranges."""


@dataclass(frozen=True, kw_only=True)
class NearAdded(Family):
    """Policies u = clip((1 + s) v + b), v being the policy's command; s and b belong to a role."""

    adjusted: Adjusted
    """The policy, with an adjustment that is to be changed."""
    roles: tuple[Role, ...]
    """The role of each actuator."""

    def make(self, values: Array) -> Adjusted:
        """Return the policy of these values."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        law = np.array(self.adjusted.law)
        own = law[:, -len(self.roles) :]
        own += np.diag([free[f"{role.name} strength"] for role in self.roles])
        shift = np.array([role.sense * free[f"{role.name} shift"] for role in self.roles])
        return replace(self.adjusted, law=law, bias=self.adjusted.bias + shift)


def near_added(policy: Policy, robot: Robot, sigma: float) -> NearAdded:
    """Return the policies near a policy that observes.

    Args:
        policy: The policy, of a kind that can be adjusted, or an adjusted one.
        robot: The body that it commands.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    known = actuator_roles(robot)
    roles = tuple(known[each.actuator] for each in policy.action)
    numbers = []
    for name, narrowest in narrowest_of(roles, policy.action).items():
        wide = SHIFTED * narrowest
        numbers.append(Number(name=f"{name} strength", low=-STRONGER, high=STRONGER, start=0.0))
        numbers.append(Number(name=f"{name} shift", low=-wide, high=wide, start=0.0))
    adjusted = policy if isinstance(policy, Adjusted) else unadjusted(policy)
    return NearAdded(adjusted=adjusted, roles=roles, numbers=tuple(numbers), sigma=sigma)


def unadjusted(policy: Policy) -> Adjusted:
    """Return a policy that observes as an adjusted one to which nothing is added yet."""
    angles = np.asarray(getattr(policy, "angles", np.zeros(policy.size)))
    actions = len(policy.action)
    size = len(policy.observation) + int(angles[newest(policy.observation)].sum()) + actions
    return Adjusted(
        source=policy,
        bias=np.zeros(actions),
        law=np.zeros((actions, size)),
        centre=np.zeros((1, size)),
        width=np.ones((actions, size)),
        weight=np.zeros((actions, 1)),
        reach=np.full(size, LARGEST),
        angles=angles,
        action=policy.action,
        period=policy.period,
        observation=policy.observation,
    )


def can_be_added_to(policy: Policy) -> bool:
    """Return whether there are such policies near a policy."""
    return isinstance(policy, Adjusted) or (type(policy) in SOURCES and policy.size > 0)
