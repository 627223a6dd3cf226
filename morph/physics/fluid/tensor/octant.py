"""An eighth of a box's surface in rectangles that grow smaller towards the edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.physics.fluid.tensor.panels import Panels

PARITY = np.array([(-1, 1, 1), (1, -1, 1), (1, 1, -1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
"""Whether the flow of each motion [v; w] keeps or changes its sign in the mirrors x, y and z."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Octant:
    """Rectangles on the three faces of a box where x, y and z are positive."""

    triangles: Panels
    """Two triangles for each rectangle, one after the other."""
    centres: Array
    """Centres of the rectangles, shape (k, 3), m."""

    @property
    def areas(self) -> Array:
        """Areas of the rectangles, shape (k,), m2."""
        return 2.0 * self.triangles.areas[::2]

    @property
    def flux(self) -> Array:
        """Normal velocity at each centre for six unit motions [v; w], shape (k, 6)."""
        normals = self.triangles.normals[::2]
        return np.concatenate([normals, np.cross(self.centres, normals)], axis=1)

    @property
    def doubled_flux(self) -> Array:
        """The same for the triangles, shape (2 k, 6)."""
        return np.repeat(self.flux, 2, axis=0)


def octant(sides: Array, counts: Integers) -> Octant:
    """Return an eighth of a box about the origin.

    Args:
        sides: Sides of the box, shape (3,), m.
        counts: Rectangles along half of each side, shape (3,).
    """
    steps = [_places(side, int(count)) for side, count in zip(sides, counts, strict=True)]
    corners = np.concatenate([_face(axis, steps) for axis in range(3)])
    halves = np.stack([corners[:, (0, 1, 2)], corners[:, (0, 2, 3)]], axis=1)
    return Octant(triangles=Panels(corners=halves.reshape(-1, 3, 3)), centres=corners.mean(axis=1))


def _places(side: float, count: int) -> Array:
    """Return where rectangles end, from the middle of a side to its edge."""
    # The distance from the edge grows as a square: the potential, which near an edge
    # goes as the distance to the power of 2/3, then varies evenly enough for second order.
    inward = np.linspace(1.0, 0.0, count + 1)
    places: Array = 0.5 * side * (1.0 - inward**2)
    return places


def _face(axis: int, steps: list[Array]) -> Array:
    """Return the corners of one face's rectangles, counter-clockwise, shape (k, 4, 3)."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    u, w = np.meshgrid(steps[one], steps[other], indexing="ij")
    grid = np.empty((*u.shape, 3))
    grid[..., axis], grid[..., one], grid[..., other] = steps[axis][-1], u, w
    ring = (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    return np.stack(ring, axis=2).reshape(-1, 4, 3)
