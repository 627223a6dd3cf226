"""Cutting polygons into triangles."""

from __future__ import annotations

import numpy as np

from morph.arrays import Integers


def fans(corners: Integers, lengths: Integers) -> Integers:
    """Return each polygon's triangles from its first corner, shape (m, 3).

    Of a plane polygon with a dent some triangles lie outside it and others
    take that back: its signed area, and so the mesh's volume, is right.

    Args:
        corners: The corners of all polygons, one polygon after another.
        lengths: How many each polygon has; those with under three have no triangle.

    Raises:
        ValueError: The lengths do not add up to the corners.
    """
    if (lengths < 0).any() or lengths.sum() != len(corners):
        raise ValueError(f"{len(corners)} corners do not make polygons of {lengths.sum()}")
    triangles = np.maximum(lengths - 2, 0)
    first = np.repeat(np.cumsum(lengths) - lengths, triangles)
    step = np.arange(triangles.sum()) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    result: Integers = corners[np.stack([first, first + step + 1, first + step + 2], axis=1)]
    return result
