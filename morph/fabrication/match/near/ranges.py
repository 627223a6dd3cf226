"""How far commands may be changed: the ranges of those of one role."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array
from morph.body.roles import Role
from morph.policy.policy import UNLIMITED, Action

WIDEST = 2.0
"""Range of a command that nothing bounds, in its unit."""


def ranges_of(action: tuple[Action, ...]) -> Array:
    """Return the range of each command, in its unit, shape (actions,)."""
    return np.array([WIDEST if each.high >= UNLIMITED else each.high - each.low for each in action])


def narrowest_of(roles: Sequence[Role], action: tuple[Action, ...]) -> dict[str, float]:
    """Return the least range of the commands of each role, by its name, from the trunk outwards."""
    ranges = ranges_of(action)
    found: dict[str, float] = {}
    for at in sorted(range(len(roles)), key=lambda at: roles[at].order):
        name = roles[at].name
        found[name] = min(float(ranges[at]), found.get(name, np.inf))
    return found
