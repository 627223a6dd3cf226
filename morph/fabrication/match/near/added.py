"""Policies near any policy that observes: its commands a little stronger, and shifted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.fabrication.match.near.roles import ranges_of, roles_of
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

    def make(self, values: Array) -> Adjusted:
        """Return the policy of these values."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        roles = roles_of(self.adjusted.action)
        law = np.array(self.adjusted.law)
        own = law[:, -len(roles) :]
        own += np.diag([free[f"{role} strength"] for role in roles])
        shift = np.array([free[f"{role} shift"] for role in roles])
        return replace(self.adjusted, law=law, bias=self.adjusted.bias + shift)


def near_added(policy: Policy, sigma: float) -> NearAdded:
    """Return the policies near a policy that observes.

    Args:
        policy: The policy, of a kind that can be adjusted, or an adjusted one.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    roles, ranges = roles_of(policy.action), ranges_of(policy.action)
    numbers = []
    for role in dict.fromkeys(roles):
        wide = SHIFTED * min(float(r) for r, own in zip(ranges, roles, strict=True) if own == role)
        numbers.append(Number(name=f"{role} strength", low=-STRONGER, high=STRONGER, start=0.0))
        numbers.append(Number(name=f"{role} shift", low=-wide, high=wide, start=0.0))
    adjusted = policy if isinstance(policy, Adjusted) else unadjusted(policy)
    return NearAdded(adjusted=adjusted, numbers=tuple(numbers), sigma=sigma)


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
