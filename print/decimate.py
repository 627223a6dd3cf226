"""Decimate a mesh for display."""

from __future__ import annotations

import numpy as np

from morph.print.mesh import Mesh

CLOSE = 1.6
"""As many times the triangles that were asked for are taken as well."""

CELLS = (200, 100, 50, 30, 18)
"""Cells along the longest side, where edges cannot be given up one by one."""


def lighter(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh of about so many triangles at most, never one to print.

    The edges go whose loss moves the surface least. Around many small holes none can; there
    corners that are near each other become one first, which closes the smallest of them.

    Source: Garland and Heckbert 1997, "Surface simplification using quadric error metrics".
    """
    if len(mesh.faces) <= most:
        return mesh
    result = _thinned(mesh, most)
    for cells in CELLS:
        if len(result.faces) <= CLOSE * most:
            break
        result = _thinned(_clustered(mesh, cells), most)
    return result


def _thinned(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh without the edges that are needed least; itself where that fails."""
    import fast_simplification

    if len(mesh.faces) <= most:
        return mesh
    corners, index = np.unique(mesh.vertices.astype(np.float32), axis=0, return_inverse=True)
    vertices, faces = fast_simplification.simplify(
        corners, index.reshape(-1)[mesh.faces].astype(np.int32), target_count=most, agg=5.0
    )
    if not len(faces) or not np.isfinite(vertices).all():
        return mesh
    return Mesh(vertices=vertices.astype(np.float64), faces=faces.astype(np.int64))


def _clustered(mesh: Mesh, cells: int) -> Mesh:
    """Return a mesh whose corners are one where they share a cell."""
    size = max(float(mesh.extent.max()), 1e-9) / cells
    _, one, index = np.unique(
        np.rint(mesh.vertices / size), axis=0, return_index=True, return_inverse=True
    )
    faces = index.reshape(-1)[mesh.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    # What was a thin wall or a hole is now faces back to back, of which nothing is seen.
    alike, times = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True)[0:2]
    single = np.bincount(times.reshape(-1), minlength=len(alike))[times.reshape(-1)] % 2 == 1
    if not single.any():
        return mesh
    return Mesh(vertices=mesh.vertices[one], faces=faces[single])
