"""Which actuators are changed alike: those of one role."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.policy.policy import UNLIMITED, Action
from morph.search.family.parts import parts_of

WIDEST = 2.0
"""Range of a command that nothing bounds, in its unit."""


def roles_of(action: tuple[Action, ...]) -> tuple[str, ...]:
    """Return the role of each actuator, such as `knee`; one without any is its own."""
    names = tuple(each.actuator for each in action)
    return tuple(part.role or name for part, name in zip(parts_of(names), names, strict=True))


def places_of(action: tuple[Action, ...]) -> Array:
    """Return where each actuator is, -1 in front to 1 at the rear, 0 where nothing tells."""
    parts = parts_of(tuple(each.actuator for each in action))
    return np.array([0.0 if part.place is None else 2.0 * part.place - 1.0 for part in parts])


def ranges_of(action: tuple[Action, ...]) -> Array:
    """Return the range of each command, in its unit, shape (actions,)."""
    return np.array([WIDEST if each.high >= UNLIMITED else each.high - each.low for each in action])
