"""What the names of actuators tell of a body's symmetry: role, side and place."""

from __future__ import annotations

import re
from dataclasses import dataclass

SIDES = {"left": 0.0, "l": 0.0, "right": 1.0, "r": 1.0}
"""Words for the side of a leg, and the share of the lag between the sides that it has."""

PLACES = {"front": 0.0, "fore": 0.0, "middle": 0.5, "rear": 1.0, "hind": 1.0}
"""Words for the place of a leg, and the share of the lag from front to rear that it has."""

IDLE = {"", "servo", "motor", "joint"}
"""Words that tell nothing."""


@dataclass(frozen=True, kw_only=True)
class ActuatorRole:
    """What the name of an actuator tells."""

    role: str
    """What is left of the name without side, place and number: `hip`, `yaw`."""
    side: float | None
    """0 for left, 1 for right, None where the name does not say."""
    place: float | None
    """0 in front to 1 at the rear, None where the name does not say."""


def parts_of(names: tuple[str, ...]) -> tuple[ActuatorRole, ...]:
    """Return what each name tells: `rear_left_knee` is a knee, left, at the rear.

    A number at the end counts from the front: `yaw_1` to `yaw_5` stand at 0 to 1.
    """
    results = [_words(name) for name in names]
    parts = []
    for role, side, place, number in results:
        row = [other[3] for other in results if other[0] == role and other[3] is not None]
        if number is not None and place is None:
            place = (number - min(row)) / max(1, max(row) - min(row))
        parts.append(ActuatorRole(role=role, side=side, place=place))
    return tuple(parts)


def _words(name: str) -> tuple[str, float | None, float | None, int | None]:
    words = [word for word in re.split(r"[_\W]+", name.lower()) if word not in IDLE]
    side = next((SIDES[word] for word in words if word in SIDES), None)
    place = next((PLACES[word] for word in words if word in PLACES), None)
    rest = [word for word in words if word not in SIDES and word not in PLACES]
    number = int(rest.pop()) if rest and rest[-1].isdecimal() else None
    return "_".join(rest), side, place, number
