"""Points spread evenly over a surface, without chance, so that a check repeats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array, Integers
from morph.print.errors import SolidError
from morph.print.mesh import Mesh

PLASTIC = 1.32471795724474602596
"""The real root of x3 = x + 1, of which the sequence below is made."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Points on a surface, each standing for the same area."""

    points: Array
    """Where they are, mm, shape (n, 3)."""
    normals: Array
    """Unit normals out of the surface, shape (n, 3)."""
    faces: Integers
    """The triangle of each, shape (n,)."""
    area: float
    """What each stands for, mm2."""


def samples(mesh: Mesh, count: int) -> Samples:
    """Return points on a mesh: triangles by their area in strides, places in them by R2.

    Source: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences": steps by
    1/p and 1/p2 with p3 = p + 1 leave no clusters and no gaps (from memory, not checked).

    Raises:
        SolidError: The mesh has no area.
    """
    a, b, c = mesh.corners.transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    doubled = np.linalg.norm(across, axis=1)
    total = float(doubled.sum()) / 2.0
    if not total > 0.0:
        raise SolidError(
            f"its {len(mesh.faces)} triangles have no area",
            where="morph.print.samples.samples",
            fix="give a mesh whose triangles enclose something",
        )
    stride = (np.arange(count) + 0.5) / count
    chosen = np.searchsorted(np.cumsum(doubled) / doubled.sum(), stride)
    chosen = np.minimum(chosen, len(doubled) - 1)
    step = np.arange(1, count + 1)[:, None] * np.array([1 / PLASTIC, 1 / PLASTIC**2])
    u, v = (step % 1.0).T
    # Points beyond the diagonal of the parallelogram are turned back into the triangle.
    beyond = u + v > 1.0
    u, v = np.where(beyond, 1.0 - u, u), np.where(beyond, 1.0 - v, v)
    points = a[chosen] + u[:, None] * (b - a)[chosen] + v[:, None] * (c - a)[chosen]
    return Samples(
        points=points,
        normals=across[chosen] / doubled[chosen][:, None],
        faces=chosen.astype(np.int64),
        area=total / count,
    )
