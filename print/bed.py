"""Whether something that lies fits a printer's bed, and how it has to be turned about upright."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from morph.print.arrays import Array
from morph.print.mesh import Mesh
from morph.print.printer import Profile

MARGIN_MM = 5.0
"""What is left free along each edge of the bed: a skirt, a brim, and clips that hold the plate."""

STEP_DEG = 3.0
"""Between the angles about upright that are tried."""


def room(profile: Profile) -> Array:
    """Return width, depth and height that a part may have, mm, shape (3,)."""
    width, depth, height = profile.printer.bed_mm
    return np.array([width - 2.0 * MARGIN_MM, depth - 2.0 * MARGIN_MM, height])


def hull(mesh: Mesh) -> Array:
    """Return the corners of a mesh that stand out: all that matters to how large it is."""
    try:
        corners: Array = mesh.vertices[ConvexHull(mesh.vertices).vertices]
    except QhullError:
        return mesh.vertices
    return corners


def about_up(points: Array, profile: Profile) -> Array | None:
    """Return the turn about upright by which points fit the bed, None if none does.

    A turn that fits is chosen for the least area of the upright box around the points, since
    boxes are what is laid on plates; so a long part lies along the bed while it can, and across
    its diagonal where it must.

    Args:
        points: As the part lies, z up, mm, shape (n, 3).
        profile: Names the printer.

    Returns:
        A rotation about z, shape (3, 3).
    """
    extent = points.max(axis=0) - points.min(axis=0)
    size = room(profile)
    if extent[2] > size[2]:
        return None
    angle = np.concatenate([_along_edges(points[:, :2]), np.deg2rad(np.arange(0, 180, STEP_DEG))])
    across = np.stack([np.cos(angle), -np.sin(angle)], axis=1) @ points[:, :2].T
    along = np.stack([np.sin(angle), np.cos(angle)], axis=1) @ points[:, :2].T
    box = np.stack([np.ptp(across, axis=1), np.ptp(along, axis=1)], axis=1)
    fits = np.flatnonzero((box <= size[:2]).all(axis=1))
    if not len(fits):
        return None
    best = angle[fits[np.argmin(box[fits].prod(axis=1).round(3))]]
    c, s = np.cos(best), np.sin(best)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _along_edges(points: Array) -> Array:
    """Return the angles that lay an edge of the outline along the bed, rad.

    The least box around a convex outline lies along one of its edges.
    Source: Freeman and Shapira 1975, Communications of the ACM 18(7).
    """
    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:
        return np.zeros(1)
    edge = np.roll(corners, -1, axis=0) - corners
    angle = -np.arctan2(edge[:, 1], edge[:, 0])
    both = np.concatenate([np.zeros(1), angle, angle + np.pi / 2.0])
    return np.unique(np.round(np.mod(both, np.pi), 6))
