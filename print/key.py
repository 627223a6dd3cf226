"""Pieces that lie against each other, given pins and holes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.cut import Plane, rotated, swapped
from morph.print.pin import common, pins
from morph.print.printer import Profile
from morph.print.section import section

OVER = np.diag([1.0, -1.0, -1.0])
"""Half a turn about x: what lay above a plane lies below it."""

MARKS = 6
"""How many joints of one part differ in how far apart their pins stand."""

TOUCH_MM = 1e-4
"""How near to a plane a piece must end to lie against it."""


@dataclass(frozen=True, kw_only=True)
class Keyed:
    """Pieces after they got pins and holes."""

    solids: tuple[Any, ...]
    """Each a `manifold3d.Manifold`, in the order given."""
    loose: str
    """Why some piece hangs on no other; empty where all hold together."""


def keyed(solids: Sequence[Any], planes: Sequence[Plane], profile: Profile) -> Keyed:
    """Return pieces with pins and holes wherever two of them lie against each other.

    Not every pair needs a pin: the pieces must hold together as a whole.
    """
    made = list(solids)
    group = list(range(len(made)))
    reasons = []
    mark = 0
    for plane in planes:
        for low, high in _pairs(solids, plane):
            pair = _joined(made[low], made[high], plane, profile, mark % MARKS)
            if pair is None:
                reasons.append(_reason(made[low], made[high], plane, profile))
                continue
            mark += 1
            made[low], made[high] = pair
            group = [group[low] if each == group[high] else each for each in group]
    apart = len(set(group)) > 1
    why = next((each for each in reasons if each), "its pieces do not lie against each other")
    return Keyed(solids=tuple(made), loose=why if apart else "")


def _pairs(solids: Sequence[Any], plane: Plane) -> list[tuple[int, int]]:
    """Return which pieces end at a plane, and which begin there, where their boxes overlap."""
    boxes = np.array([solid.bounding_box() for solid in solids]).reshape(-1, 2, 3)
    ends = np.flatnonzero(np.abs(boxes[:, 1, plane.axis] - plane.height) < TOUCH_MM)
    begins = np.flatnonzero(np.abs(boxes[:, 0, plane.axis] - plane.height) < TOUCH_MM)
    other = [axis for axis in range(3) if axis != plane.axis]
    return [
        (int(low), int(high))
        for low in ends
        for high in begins
        if (boxes[low, 0, other] < boxes[high, 1, other]).all()
        and (boxes[high, 0, other] < boxes[low, 1, other]).all()
    ]


def _joined(
    low: Any, high: Any, plane: Plane, profile: Profile, mark: int
) -> tuple[Any, Any] | None:
    """Return a piece with pins and one with holes, whichever way there is more room for them."""
    up = swapped(plane.axis)
    below, above = (_onto(solid, up, plane.height) for solid in (low, high))
    flipped = rotated(above, OVER), rotated(below, OVER)
    ways = [
        (pins(below, above, profile, mark=mark), False),
        (pins(*flipped, profile, mark=mark), True),
    ]
    # Two pins rather than a D, then the thicker ones, then as the axis runs.
    result, over = max(
        ways, key=lambda way: (len(way[0]), max((p.radius for p in way[0]), default=0))
    )
    if not result:
        return None
    for pin in result:
        solid, hole = pin.solid(), pin.hole(profile.clearance_mm)
        if over:
            above, below = above + rotated(solid, OVER), below - rotated(hole, OVER)
        else:
            below, above = below + solid, above - hole
    return _back(below, up, plane.height), _back(above, up, plane.height)


def _onto(solid: Any, up: Array, height: float) -> Any:
    """Return a solid turned so that the plane is z = 0."""
    return rotated(solid, up).translate((0.0, 0.0, -height))


def _back(solid: Any, up: Array, height: float) -> Any:
    """Return what `_onto` turned as it was."""
    return rotated(solid.translate((0.0, 0.0, height)), up.T)


def _reason(low: Any, high: Any, plane: Plane, profile: Profile) -> str:
    """Return why no pin has room between two pieces; empty where they hardly touch."""
    up = swapped(plane.axis)
    below, above = (_onto(solid, up, plane.height) for solid in (low, high))
    result = section(common(below, above, 1.0))
    if result is None:
        return ""
    needed = 1.25 + profile.clearance_mm + profile.thinnest_mm
    return (
        f"where it would be cut, the largest circle in its section has a radius of "
        f"{result.deepest:.1f} mm, and a pin with play and walls needs {needed:.2f} mm, and as "
        f"much depth"
    )
