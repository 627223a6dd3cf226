"""Planes that cut a solid into pieces: how many along each axis, and at which heights."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.section import section

MOST = 48
"""Pieces that a part is cut into at most."""

TRIED = 9
"""How many heights are looked at for each plane."""

ENOUGH_MM = 7.0
"""Radius of the largest circle in a section; a larger one makes a cut no better."""


ROUGHLY = 20_000
"""Squares of a section when heights are compared."""


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A plane across an axis."""

    axis: int
    """0, 1 or 2."""
    height: float
    """Where on the axis, mm."""


def plans(size: Array, room: Array) -> Iterator[tuple[int, int, int]]:
    """Yield how often to cut along each axis, as numbers of slices, the fewest pieces first.

    Args:
        size: Extent of the solid, mm, shape (3,).
        room: What a printer has room for, mm, shape (3,).
    """
    longest = float(np.linalg.norm(room))
    # No slice is longer than the room's diagonal, so fewer slices need not be tried.
    least = np.maximum(np.ceil(size / longest), 1).astype(int)
    counts = itertools.product(*(range(int(low), MOST + 1) for low in least))
    few = [(x, y, z) for x, y, z in counts if 1 < x * y * z <= MOST]
    # Of equally many pieces, those nearest to cubes have the smallest sections to join.
    return iter(sorted(few, key=lambda each: (math.prod(each), float((size / each).max()))))


def swapped(axis: int) -> Array:
    """Return the rotation that takes an axis to z, shape (3, 3)."""
    return np.roll(np.eye(3), axis - 2, axis=1) if axis != 2 else np.eye(3)


def rotated(solid: Any, turn: Array) -> Any:
    """Return a `manifold3d.Manifold` under a rotation, shape (3, 3)."""
    return solid.transform(np.concatenate([turn, np.zeros((3, 1))], axis=1))


def chosen(
    solid: Any, axis: int, count: int, freedom: float, taken: Sequence[tuple[float, float]]
) -> tuple[Plane, ...] | None:
    """Return the planes that cut a solid into slices, each where its section is stoutest.

    Args:
        solid: A `manifold3d.Manifold`.
        axis: Along which it is cut.
        count: Number of slices.
        freedom: How far a plane may be from where slices would be equally thick, in slices.
        taken: Spans of the axis where nothing may be cut, mm.

    Returns:
        The planes; None if a plane has no height that is not taken.
    """
    turned = rotated(solid, swapped(axis))
    bounds = turned.bounding_box()
    low, high = bounds[2], bounds[5]
    slice_mm = (high - low) / count
    planes = []
    for at in range(1, count):
        middle = low + at * slice_mm
        heights = np.unique(middle + freedom * slice_mm * np.linspace(-1.0, 1.0, TRIED))
        free = [z for z in heights if not any(begin < z < end for begin, end in taken)]
        if not free:
            return None
        planes.append(
            Plane(axis=axis, height=float(max(free, key=lambda z: _stout(turned, z, middle))))
        )
    return tuple(planes)


def _stout(turned: Any, height: float, middle: float) -> tuple[float, float]:
    """Return how good a cut is: by the largest circle in it, then by how near to the middle."""
    result = section(turned.slice(float(height)), squares=ROUGHLY)
    deepest = 0.0 if result is None else result.deepest
    return (round(min(deepest, ENOUGH_MM), 1), -abs(height - middle))


def even(size: Array, low: Array, counts: Sequence[int]) -> tuple[Plane, ...]:
    """Return planes that cut a box from `low` on into slices of equal thickness."""
    return tuple(
        Plane(axis=axis, height=float(low[axis] + size[axis] * at / count))
        for axis, count in enumerate(counts)
        for at in range(1, count)
    )


def cut(solid: Any, planes: Sequence[Plane]) -> list[Any]:
    """Return the separate solids that planes leave."""
    pieces = [solid]
    for plane in planes:
        normal = np.eye(3)[plane.axis]
        halves = [half for piece in pieces for half in piece.split_by_plane(normal, plane.height)]
        pieces = [half for half in halves if not half.is_empty()]
    return [one for piece in pieces for one in piece.decompose()]
