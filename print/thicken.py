"""Thin discs and plates of a drawing, made thick enough to print."""

from __future__ import annotations

import numpy as np

from morph.print.mesh import Mesh


def thickened(mesh: Mesh, least_mm: float) -> Mesh:
    """Return a simple solid whose least width is at least so much; itself if it is.

    It is stretched about its middle along the principal axes of its surface, which for
    boxes, cylinders, capsules and ellipsoids are those along which it is thin.
    """
    middle = mesh.trimesh.convex_hull.center_mass
    away = mesh.vertices - middle
    values, axes = np.linalg.eigh(mesh.trimesh.convex_hull.moment_inertia)
    along = away @ axes
    width = np.ptp(along, axis=0)
    stretch = np.maximum(1.0, least_mm / np.maximum(width, 1e-9))
    if not np.any(stretch > 1.0 + 1e-9) or not np.all(np.isfinite(values)):
        return mesh
    return Mesh(vertices=middle + (along * stretch) @ axes.T, faces=mesh.faces)
