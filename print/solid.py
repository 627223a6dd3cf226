"""Boxes and round things as `manifold3d` solids, in millimetres, to grow and to cut parts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from morph.print.arrays import Array

SAGITTA = 0.02
"""How far a flat face may lie inside the round one that it stands for, mm."""

FEWEST, MOST = 24, 96
"""Fewest and most faces around a circle."""

NOTHING = 1e-6
"""Volume below which two solids only touch, mm3."""


def around(radius: float) -> int:
    """Return how many faces stand for a circle, mm: a multiple of 8, so that it is symmetric.

    A chord of n lies r (1 - cos(pi / n)) inside its arc.
    """
    wanted = math.pi / math.acos(1.0 - min(SAGITTA / max(radius, SAGITTA), 0.5))
    return 8 * math.ceil(min(max(wanted, FEWEST), MOST) / 8)


def box(low: Sequence[float], high: Sequence[float]) -> Any:
    """Return the box between two corners, mm."""
    import manifold3d

    size = [float(b) - float(a) for a, b in zip(low, high, strict=True)]
    return manifold3d.Manifold.cube(size).translate([float(a) for a in low])


def rod(radius: float, low: float, high: float, at: tuple[float, float] = (0.0, 0.0)) -> Any:
    """Return a cylinder along z between two heights, mm."""
    import manifold3d

    shape = manifold3d.Manifold.cylinder(high - low, radius, radius, around(radius))
    return shape.translate([at[0], at[1], low])


def ball(radius: float, at: Array) -> Any:
    """Return a ball about a point, mm."""
    import manifold3d

    shape = manifold3d.Manifold.sphere(radius, around(radius))
    return shape.translate([float(x) for x in at])


def hull(solids: Sequence[Any]) -> Any:
    """Return the convex hull around solids."""
    import manifold3d

    return manifold3d.Manifold.batch_hull(list(solids))


def union(solids: Iterable[Any]) -> Any:
    """Return solids as one; of none, nothing."""
    import manifold3d

    return manifold3d.Manifold.batch_boolean(list(solids), manifold3d.OpType.Add)


def grown(solid: Any, by: float) -> Any:
    """Return the hull of a solid, grown on all sides, mm; its corners stay sharp along x, y, z."""
    import manifold3d

    if by <= 0.0:
        return solid.hull()
    cube = manifold3d.Manifold.cube([2.0 * by] * 3, center=True)
    return solid.hull().minkowski_sum(cube).hull()


def placed(solid: Any, pose: Array) -> Any:
    """Return a solid under a transform, shape (4, 4), mm."""
    return solid.transform(np.ascontiguousarray(pose[:3, :4], dtype=np.float64))


def frame(position: Array, axis: Array) -> Array:
    """Return the pose of a frame whose z lies along an axis, shape (4, 4)."""
    z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    # The axis that it is least along: a fixed choice, so that equal parts come out equal.
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = position
    return pose


def pieces(solid: Any) -> list[Any]:
    """Return the separate pieces of a solid, the largest first; voids inside are filled."""
    results = [piece for piece in solid.decompose() if piece.volume() > NOTHING]
    return sorted(results, key=lambda piece: -piece.volume())
