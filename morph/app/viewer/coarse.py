"""A mesh with fewer faces that still looks like itself."""

from __future__ import annotations

import numpy as np

from morph.body.mesh.solid import Mesh
from morph.body.mesh.thin import thinned

CLOSE = 1.1
"""As many times the faces that were asked for are taken as well."""

CAREFUL = 5.0
"""How readily faces are given up, 0 to 10; more is faster, and coarser."""


def coarse(mesh: Mesh, most: int, stubborn: set[bytes] | None = None) -> Mesh:
    """Return a mesh of about so many faces at most; itself if it has no more.

    The edges go whose loss moves the surface least. Many loose pieces cannot be thinned so;
    corners are clustered there, which always can be done, and shows more.

    Source: Garland and Heckbert 1997, "Surface simplification using quadric error metrics".

    Args:
        mesh: The mesh.
        most: Faces that it may have.
        stubborn: Faces that could not be thinned so before; filled. A body has the same mesh in
            many places, and each vain attempt takes longer than all else.
    """
    if len(mesh.faces) <= most:
        return mesh
    stubborn = set() if stubborn is None else stubborn
    if (known := mesh.faces.tobytes()) in stubborn:
        return thinned(mesh, most)
    import fast_simplification

    corners, index = np.unique(mesh.vertices.astype(np.float32), axis=0, return_inverse=True)
    vertices, faces = fast_simplification.simplify(
        corners,
        index.reshape(-1)[mesh.faces].astype(np.int32),
        target_count=most,
        agg=CAREFUL,
    )
    if not 0 < len(faces) <= CLOSE * most or not np.isfinite(vertices).all():
        stubborn.add(known)
        return thinned(mesh, most)
    return Mesh(vertices=vertices.astype(np.float64), faces=faces.astype(np.int64))
