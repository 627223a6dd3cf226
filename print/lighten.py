"""A mesh with fewer triangles, to be looked at only."""

from __future__ import annotations

import numpy as np

from print.mesh import Mesh

CLOSE = 2.0
"""As many times the triangles that were asked for are taken as well."""

CELLS = (200, 120, 70, 40)
"""Cells along the longest side, where edges cannot be given up one by one."""


def lighter(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh of about so many triangles at most, never one to print.

    Source: Garland and Heckbert 1997, "Surface simplification using quadric error metrics".
    """
    if len(mesh.faces) <= most:
        return mesh
    import fast_simplification

    corners, index = np.unique(mesh.vertices.astype(np.float32), axis=0, return_inverse=True)
    vertices, faces = fast_simplification.simplify(
        corners, index.reshape(-1)[mesh.faces].astype(np.int32), target_count=most, agg=5.0
    )
    if not len(faces) or not np.isfinite(vertices).all():
        return mesh
    found = Mesh(vertices=vertices.astype(np.float64), faces=faces.astype(np.int64))
    for cells in CELLS:
        if len(found.faces) <= CLOSE * most:
            break
        found = _clustered(mesh, cells)
    return found


def _clustered(mesh: Mesh, cells: int) -> Mesh:
    """Return a mesh whose corners are one where they share a cell: what is full of holes thins."""
    size = max(float(mesh.extent.max()), 1e-9) / cells
    _, one, index = np.unique(
        np.rint(mesh.vertices / size), axis=0, return_index=True, return_inverse=True
    )
    faces = index.reshape(-1)[mesh.faces]
    kept = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    if not kept.any():
        return mesh
    return Mesh(vertices=mesh.vertices[one], faces=faces[kept])
