"""Simple solids in millimetres: what a description draws without a mesh."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.print.mesh import Mesh, from_manifold
from morph.print.solid import around


def solid(kind: str, size: Array) -> Mesh | None:
    """Return a solid about its own middle, its length along z; None of a kind without an end.

    Args:
        kind: `box`, `sphere`, `ellipsoid`, `cylinder` or `capsule`.
        size: As MuJoCo's: halves along x, y, z; or radius and half the length; mm, shape (3,).
    """
    maker = MAKERS.get(kind)
    return None if maker is None else from_manifold(maker(size))


MOST_OF_A_BALL = 64
"""Most faces around a ball: its triangles grow with the square, and what is cut pays for each."""


def _ball(radius: float, size: float) -> Any:
    import manifold3d

    return manifold3d.Manifold.sphere(radius, min(around(size), MOST_OF_A_BALL))


def _box(size: Array) -> Any:
    import manifold3d

    return manifold3d.Manifold.cube(list(2.0 * size), center=True)


def _sphere(size: Array) -> Any:
    return _ball(float(size[0]), float(size[0]))


def _ellipsoid(size: Array) -> Any:
    return _ball(1.0, float(size.max())).scale(list(size))


def _cylinder(size: Array) -> Any:
    import manifold3d

    radius, half = float(size[0]), float(size[1])
    return manifold3d.Manifold.cylinder(2.0 * half, radius, -1.0, around(radius), True)


def _capsule(size: Array) -> Any:
    import manifold3d

    ball, half = _sphere(size), float(size[1])
    ends = [ball.translate([0.0, 0.0, -half]), ball.translate([0.0, 0.0, half])]
    return manifold3d.Manifold.batch_hull(ends)


MAKERS: dict[str, Callable[[Array], Any]] = {
    "box": _box,
    "sphere": _sphere,
    "ellipsoid": _ellipsoid,
    "cylinder": _cylinder,
    "capsule": _capsule,
}
"""What makes each kind."""


def placed(rotation: Array, position: Array) -> Array:
    """Return a transform, shape (4, 4), of a rotation, 9 numbers, and a position, 3."""
    pose = np.eye(4)
    pose[:3, :3] = np.reshape(rotation, (3, 3))
    pose[:3, 3] = position
    return pose
