"""A mesh with fewer triangles, to be looked at only."""

from __future__ import annotations

import numpy as np

from print.mesh import Mesh


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
    return Mesh(vertices=vertices.astype(np.float64), faces=faces.astype(np.int64))
