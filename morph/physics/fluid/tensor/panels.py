"""Flat triangles that cover a closed surface, as the boundary elements see them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array, Integers

NIL = 1e-14
"""Area, as a part of the whole, below which a triangle is left out: it carries nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Panels:
    """Triangles wound counter-clockwise from outside; they need not meet corner to corner."""

    corners: Array
    """Corners of each triangle, shape (m, 3, 3), m."""

    def __len__(self) -> int:
        return len(self.corners)

    @cached_property
    def double_areas(self) -> Array:
        """Normals times twice the areas, shape (m, 3), m2."""
        a, b, c = self.corners.transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    @cached_property
    def areas(self) -> Array:
        """Areas, shape (m,), m2."""
        areas: Array = 0.5 * np.linalg.norm(self.double_areas, axis=1)
        return areas

    @cached_property
    def normals(self) -> Array:
        """Unit normals out of the body, shape (m, 3)."""
        normals: Array = self.double_areas / (2.0 * self.areas[:, None])
        return normals

    @cached_property
    def centroids(self) -> Array:
        """Centres, shape (m, 3), m."""
        centroids: Array = self.corners.mean(axis=1)
        return centroids

    @cached_property
    def flux(self) -> Array:
        """Normal velocity at each centroid for six unit motions [v; w], shape (m, 6).

        For v it is n, for w it is c x n, as (w x c) . n = w . (c x n) (Lamb 1932, art. 118).
        """
        return np.concatenate([self.normals, np.cross(self.centroids, self.normals)], axis=1)


def panels_of(vertices: Array, faces: Integers) -> Panels:
    """Return the panels of a mesh, without triangles that have no area."""
    corners = np.asarray(vertices, dtype=np.float64)[np.asarray(faces, dtype=np.int64)]
    a, b, c = corners.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Panels(corners=corners[areas > NIL * areas.sum()])
