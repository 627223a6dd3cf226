"""The room that convex solids sweep when a joint turns or slides over its range."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.fabrication.solids import placed
from morph.print.part import Hinge
from morph.print.solid import hull, union
from morph.print.solid import placed as moved

STEP = math.radians(20.0)
"""Turn between two poses whose hull is taken, with a third between them, moved outward."""

COARSE_MM = 0.1
"""How far surfaces may be moved to have fewer triangles: of hulls that cross there are many."""

WAYS = 74
"""Directions in which a rough solid reaches as far as what it stands for."""


def swept(solids: Sequence[Any], hinge: Hinge, near: Array, *, back: bool = False) -> Any:
    """Return the room that convex solids sweep, as a solid in the world at zero.

    Args:
        solids: `manifold3d` solids in the world with all joints at zero.
        hinge: The joint.
        near: Least and greatest coordinates of where it matters, mm, shape (2, 3).
        back: Whether what stays is swept, as what moves sees it.
    """
    poses = _poses(hinge, back)
    hulls = [
        hull([moved(solid, pose) for pose in three])
        for solid in solids
        for three in zip(poses[::2], poses[1::2], poses[2::2], strict=False)
    ]
    return union(each for each in hulls if _meets(each, near)).simplify(COARSE_MM)


def rough(points: Array, grow: float) -> Any:
    """Return a convex solid about points, a little larger, that is quick to cut with.

    Args:
        points: Corners of what it stands for, mm, shape (n, 3).
        grow: By how much it reaches further on all sides, mm.
    """
    import manifold3d

    ways = _directions()
    middle = points.mean(axis=0)
    furthest = points[np.argmax(points @ ways.T, axis=0)]
    corners = np.unique(np.round(furthest, 6), axis=0)
    away = corners - middle
    return manifold3d.Manifold.hull_points(corners + grow * np.sign(np.round(away, 3)))


def _meets(solid: Any, near: Array) -> bool:
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    return bool(np.all((low <= near[1]) & (near[0] <= high)))


def _poses(hinge: Hinge, back: bool) -> list[Array]:
    """Return poses from one end to the other; every second one is moved outward.

    A chord over an angle a lies cos(a / 2) inside its arc: what is in the middle of it is scaled
    by the inverse, away from the axis, so that the hull of three holds the arc.
    """
    low, high = (-hinge.high, -hinge.low) if back else (hinge.low, hinge.high)
    if hinge.kind == "slide":
        return [placed(np.eye(3), at * hinge.axis) for at in (low, (low + high) / 2, high)]
    count = max(1, math.ceil((high - low) / STEP))
    outward = 1.0 / math.cos((high - low) / count / 4.0)
    return [
        _turn(hinge, angle, outward if at % 2 else 1.0)
        for at, angle in enumerate(np.linspace(low, high, 2 * count + 1))
    ]


def _turn(hinge: Hinge, angle: float, outward: float) -> Array:
    """Return the turn about a hinge's axis, scaled across it, shape (4, 4): Rodrigues' formula."""
    x, y, z = hinge.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    along = np.outer(hinge.axis, hinge.axis)
    turn = (along + outward * (np.eye(3) - along)) @ turn
    return placed(turn, hinge.position - turn @ hinge.position)


@lru_cache(maxsize=1)
def _directions() -> Array:
    """Return directions spread over the ball, with those along the axes, shape (n, 3)."""
    at = np.arange(WAYS) + 0.5
    height, angle = 1.0 - 2.0 * at / WAYS, math.pi * (1.0 + math.sqrt(5.0)) * at
    flat = np.sqrt(1.0 - height**2)
    spiral = np.column_stack([flat * np.cos(angle), flat * np.sin(angle), height])
    return np.concatenate([spiral, np.eye(3), -np.eye(3)])
