"""A cross-section as squares: where in it there is material, and how far it is to the edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

from morph.print.arrays import Array, Mask

SQUARES = 250_000
"""About how many squares a section is divided into."""

FINEST_MM = 0.1
"""Least side of a square."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Section:
    """A cross-section on a grid."""

    inside: Mask
    """Where the middle of a square is material, shape (rows, columns)."""
    depth: Array
    """How far each middle is from the edge, at least, mm; 0 outside."""
    origin: Array
    """Middle of the first square, mm, shape (2,)."""
    pitch: float
    """Side of a square, mm."""

    def outermost(self, depth: float) -> Array:
        """Return the first and last place of each row that lies at least so deep, mm, shape (n, 2).

        Of any two such places that are as far apart as can be, both are among them.
        """
        rows = np.flatnonzero((self.depth >= depth).any(axis=1))
        row = self.depth[rows] >= depth
        columns = np.stack([row.argmax(axis=1), row.shape[1] - 1 - row[:, ::-1].argmax(axis=1)])
        points: Array = self.origin + self.pitch * np.stack(
            [columns.ravel(), np.tile(rows, 2)], axis=1
        )
        return points

    def at(self, point: Array) -> float:
        """Return how deep a point lies, mm; 0 outside."""
        column, row = np.round((point - self.origin) / self.pitch).astype(int)
        rows, columns = self.depth.shape
        return float(self.depth[row, column]) if 0 <= row < rows and 0 <= column < columns else 0.0

    @property
    def deepest(self) -> float:
        """Radius of the largest circle in it, mm."""
        return float(self.depth.max(initial=0.0))


def section(shape: Any, *, squares: int = SQUARES) -> Section | None:
    """Return a `manifold3d.CrossSection` on a grid; None where it is empty."""
    if shape.is_empty() or shape.area() <= 0.0:
        return None
    low_x, low_y, high_x, high_y = shape.bounds()
    low, size = np.array([low_x, low_y]), np.array([high_x - low_x, high_y - low_y])
    pitch = max(FINEST_MM, float(np.sqrt(size.prod() / squares)))
    # One empty square all around: the outside is what distances are measured to.
    columns, rows = (np.ceil(size / pitch).astype(int) + 2).tolist()
    origin = low - 0.5 * pitch
    inside = _filled(shape.to_polygons(), origin, pitch, rows, columns)
    # Distances run between middles; the edge may be half a square nearer.
    depth = np.maximum(distance_transform_edt(inside) * pitch - 0.5 * pitch, 0.0)
    return Section(inside=inside, depth=depth, origin=origin, pitch=pitch)


def _filled(polygons: Any, origin: Array, pitch: float, rows: int, columns: int) -> Mask:
    """Return which middles lie within polygons: those with an odd number of edges to their left."""
    points = [(np.asarray(each, dtype=np.float64) - origin) / pitch for each in polygons]
    start = np.concatenate(points)
    end = np.concatenate([np.roll(each, -1, axis=0) for each in points])
    low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    first = np.clip(np.ceil(low), 0, rows).astype(np.int64)
    count = np.clip(np.ceil(high), 0, rows).astype(np.int64) - first
    edge = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + first[edge]
    share = (row - start[edge, 1]) / (end[edge, 1] - start[edge, 1])
    x = start[edge, 0] + share * (end[edge, 0] - start[edge, 0])
    column = np.clip(np.ceil(x), 0, columns).astype(np.int64)
    crossed = np.bincount(row * (columns + 1) + column, minlength=rows * (columns + 1))
    odd = np.cumsum(crossed.reshape(rows, columns + 1), axis=1)[:, :columns] % 2
    mask: Mask = odd == 1
    return mask
