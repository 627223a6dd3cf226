"""Cross-sections of a solid at the heights at which a slicer cuts it, and their moments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.mesh import Mesh

FINE_MM = 0.01
"""Corners nearer than this to a straight line are left out of sections."""

Section = Any
"""A `manifold3d.CrossSection`: the area inside a solid at one height."""


def sections(mesh: Mesh, layer_mm: float) -> list[Section]:
    """Return the section of each layer, cut at its middle as slicers do; the lowest first.

    Args:
        mesh: A solid that stands on height 0.
        layer_mm: Height of a layer.

    Raises:
        SolidError: The mesh encloses no solid.
    """
    solid = mesh.manifold
    count = int(np.ceil(mesh.bounds[1, 2] / layer_mm - 0.5 - 1e-6))
    return [
        solid.slice((layer + 0.5) * layer_mm).simplify(FINE_MM) for layer in range(max(count, 1))
    ]


def inset(section: Section, distance_mm: float) -> Section:
    """Return a section without what is nearer than a distance to its outline."""
    import manifold3d

    return section.offset(-distance_mm, manifold3d.JoinType.Miter, 2.0)


def grown(section: Section, distance_mm: float) -> Section:
    """Return a section and all that is nearer to it than a distance, with sharp corners."""
    import manifold3d

    return section.offset(distance_mm, manifold3d.JoinType.Miter, 2.0)


def shared(several: Sequence[Section]) -> Section:
    """Return what several sections have in common."""
    import manifold3d

    if len(several) == 1:
        return several[0]
    return manifold3d.CrossSection.batch_boolean(list(several), manifold3d.OpType.Intersect)


def all_of(several: Sequence[Section]) -> Section:
    """Return the union of sections; of none it is empty."""
    import manifold3d

    return manifold3d.CrossSection.batch_boolean(list(several), manifold3d.OpType.Add)


def moments(section: Section) -> Array:
    """Return area, first and second moments: the integrals of 1, x, y, x2, xy and y2.

    Source: Green's theorem, as in Steger 1996, On the calculation of arbitrary moments of
    polygons; outlines of holes wind the other way and so count negative.

    Returns:
        In mm2, mm3 and mm4, shape (6,).
    """
    rings = section.to_polygons()
    if not rings:
        return np.zeros(6)
    here = np.concatenate(rings)
    there = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    x, y = here.T
    u, v = there.T
    cross = x * v - u * y
    sums: Array = np.array(
        [
            cross.sum() / 2.0,
            cross @ (x + u) / 6.0,
            cross @ (y + v) / 6.0,
            cross @ (x * x + x * u + u * u) / 12.0,
            cross @ (2.0 * x * y + x * v + u * y + 2.0 * u * v) / 24.0,
            cross @ (y * y + y * v + v * v) / 12.0,
        ]
    )
    return sums
