"""Which policies are near a policy, by its kind."""

from __future__ import annotations

from morph.body.robot import Robot
from morph.fabrication.match.near.added import can_be_added_to, near_added
from morph.fabrication.match.near.linear import near_linear
from morph.fabrication.match.near.pattern import near_pattern
from morph.policy.linear import Linear
from morph.policy.pattern import Pattern
from morph.policy.policy import Policy
from morph.search.family.family import Family


def near(policy: Policy, robot: Robot, sigma: float) -> Family | None:
    """Return the policies near one; its own point is the middle of the cube. None: there are none.

    Args:
        policy: The policy.
        robot: The body that it commands.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    if isinstance(policy, Pattern):
        return near_pattern(policy, robot, sigma)
    if isinstance(policy, Linear):
        return near_linear(policy, robot, sigma)
    return near_added(policy, robot, sigma) if can_be_added_to(policy) else None
