"""What of a solid, as it lies, must be supported, and how much of it touches the bed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array, Integers, Mask
from morph.print.printer import Profile

CELLS = 4000
"""About how many columns stand on the box around what is looked at."""

FINEST_MM = 0.4
"""Least side of a column: nothing narrower than a line is printed."""

OFF = (0.38196601, 0.56984029)
"""Where in its square a column stands; irrational, so that it meets no edge of a drawn shape."""


@dataclass(frozen=True, kw_only=True)
class Standing:
    """How something stands on the bed."""

    support_mm3: float
    """Volume under faces that need support, down to what lies below them or the bed."""
    supported_mm2: float
    """Area of those faces as seen from below."""
    contact_mm2: float
    """Area that touches the bed."""


def overhanging(normals: Array, profile: Profile) -> Mask:
    """Return which faces lean out further than is printed without support.

    Args:
        normals: Unit normals, z up, shape (..., 3).
        profile: Names the angle from upright.
    """
    mask: Mask = -normals[..., 2] > np.sin(np.deg2rad(profile.overhang_deg)) + 1e-9
    return mask


def standing(corners: Array, profile: Profile, *, cells: int = CELLS) -> Standing:
    """Return how a solid stands, by columns: each face is met where a column passes it.

    Args:
        corners: Of its triangles as it lies on the bed, z up, mm, shape (m, 3, 3).
        profile: Names the angle that needs support, and the layer.
        cells: About how many columns.
    """
    points = corners.reshape(-1, 3)
    low = points.min(axis=0)
    size = points.max(axis=0) - low
    pitch = max(FINEST_MM, float(np.sqrt(size[0] * size[1] / cells)))
    column, height, leans = _met(corners - low, pitch, profile)
    order = np.lexsort((height, column))
    column, height, leans = column[order], height[order], leans[order]
    below = np.concatenate([[0.0], height[:-1]])
    below[np.concatenate([[True], column[1:] != column[:-1]])] = 0.0
    # The first layer is one thickness high: what begins within it lies on the bed.
    on_bed = leans & (height < profile.layer_mm)
    held = leans & ~on_bed
    return Standing(
        support_mm3=float((height - below)[held].sum() * pitch**2),
        supported_mm2=float(held.sum() * pitch**2),
        contact_mm2=float(on_bed.sum() * pitch**2),
    )


def _met(corners: Array, pitch: float, profile: Profile) -> tuple[Integers, Array, Mask]:
    """Return where columns meet faces: which column, how high, and whether the face leans out."""
    flat = corners[..., :2] / pitch - OFF
    first = np.ceil(_least(flat)).astype(np.int64)
    many = np.floor(-_least(-flat)).astype(np.int64) - first + 1
    # Most faces of a fine mesh lie between columns, and are done with.
    some = np.flatnonzero((many > 0).all(axis=1))
    a, b, c = corners[some].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    seen = np.abs(normal[:, 2]) > 1e-9 * np.maximum(length, 1e-30)
    some, a, normal, length = some[seen], a[seen], normal[seen], length[seen]
    flat, first, many = flat[some], first[some], many[some]
    leans = overhanging(normal / length[:, None], profile)
    face, x, y = _columns(first, many)
    inside = _inside(flat, face, np.stack([x, y], axis=1).astype(np.float64))
    face, x, y = face[inside], x[inside], y[inside]
    away = (np.stack([x, y], axis=1) + OFF) * pitch - a[face, :2]
    # A plane's height: n . (p - a) = 0, solved for z.
    height = a[face, 2] - (normal[face, :2] * away).sum(axis=1) / normal[face, 2]
    across = int(x.max(initial=0)) + 1
    return y * across + x, height, leans[face]


def _least(flat: Array) -> Array:
    """Return the least of each triangle's corners, shape (m, 2)."""
    return np.minimum(np.minimum(flat[:, 0], flat[:, 1]), flat[:, 2])


def _columns(first: Integers, many: Integers) -> tuple[Integers, Integers, Integers]:
    """Return every column in the box around every face: the face, and the column's place."""
    count = many.prod(axis=1)
    face = np.repeat(np.arange(len(count)), count)
    at = np.arange(len(face)) - np.repeat(np.cumsum(count) - count, count)
    return face, first[face, 0] + at % many[face, 0], first[face, 1] + at // many[face, 0]


def _inside(flat: Array, face: Integers, point: Array) -> Mask:
    """Return which points lie within their triangle, by the signs of three areas."""
    signs = []
    for begin, end in ((0, 1), (1, 2), (2, 0)):
        edge = (flat[:, end] - flat[:, begin])[face]
        away = point - flat[face, begin]
        signs.append(edge[:, 0] * away[:, 1] - edge[:, 1] * away[:, 0])
    low, high = np.minimum.reduce(signs), np.maximum.reduce(signs)
    mask: Mask = (low >= 0) | (high <= 0)
    return mask
