"""Ways in which a part can lie, each as the direction in the part's frame that points down."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from morph.print.arrays import Array
from morph.print.mesh import Mesh

FACES = 60
"""How many faces of its convex hull are tried, the largest first."""

SPREAD = 162
"""How many more directions are tried, spread over the sphere."""


def resting(mesh: Mesh) -> Array:
    """Return the directions in which it stands on a face of its convex hull, shape (n, 3).

    Faces that differ by less than a degree count as one.
    """
    try:
        shell = ConvexHull(mesh.vertices)
    except QhullError:
        return np.concatenate([np.eye(3), -np.eye(3)])
    normals = shell.equations[:, :3]
    corners = mesh.vertices[shell.simplices]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    # A flat face is many triangles: what points the same way is one, and the largest are met first.
    alike, group = np.unique(np.round(normals, 3), axis=0, return_inverse=True)
    total = np.bincount(group.ravel(), weights=areas)
    result = np.empty((0, 3))
    for at in np.argsort(-total, kind="stable"):
        normal = alike[at] / np.linalg.norm(alike[at])
        if len(result) == FACES:
            break
        if not len(result) or (result @ normal).max() < np.cos(np.deg2rad(1.0)):
            result = np.concatenate([result, normal[None]])
    return result


def spread(count: int = SPREAD) -> Array:
    """Return directions spread evenly over the sphere, shape (count, 3).

    Source: Gonzalez 2010, Mathematical Geosciences 42(1): the Fibonacci lattice.
    """
    at = np.arange(count) + 0.5
    z = 1.0 - 2.0 * at / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * at
    out = np.sqrt(1.0 - z**2)
    return np.stack([out * np.cos(turn), out * np.sin(turn), z], axis=1)


def turned_down(direction: Array) -> Array:
    """Return the rotation that makes a unit vector point to -z, shape (3, 3)."""
    down = np.array([0.0, 0.0, -1.0])
    axis, cosine = np.cross(direction, down), float(direction @ down)
    if cosine < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # Rodrigues' formula with (1 - cos) / sin2 written as 1 / (1 + cos).
    turn: Array = np.eye(3) + skew + skew @ skew / (1.0 + cosine)
    return turn
