"""Closed meshes as solids of manifold3d, which joins and simplifies them exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.body.mesh import Mesh


def as_manifold(mesh: Mesh) -> Any:
    """Return a closed mesh as a `manifold3d.Manifold`; its `status` tells whether it is one."""
    # Loads a library that few need.
    from manifold3d import Manifold, Mesh64

    faces = np.ascontiguousarray(mesh.faces, dtype=np.uint64)
    return Manifold(Mesh64(np.ascontiguousarray(mesh.vertices), faces))


def from_manifold(solid: Any) -> Mesh:
    """Return a `manifold3d.Manifold` as a mesh."""
    result = solid.to_mesh64()
    return Mesh(
        vertices=np.array(result.vert_properties[:, :3], dtype=np.float64),
        faces=np.array(result.tri_verts, dtype=np.int64),
    )


def simplified(mesh: Mesh, tolerance: float) -> Mesh:
    """Return a closed mesh with as few faces as a tolerance allows, m; itself if it has no fewer.

    Cuts and unions leave needles behind, each of which would otherwise be cut into many.
    """
    from manifold3d import Error

    solid = as_manifold(mesh)
    if solid.status() != Error.NoError:
        return mesh
    result = from_manifold(solid.simplify(tolerance))
    # Of a body thinner than the tolerance nothing is left.
    return result if 3 < len(result.faces) < len(mesh.faces) and result.consistent else mesh


def refined(mesh: Mesh, length: float) -> Mesh:
    """Return a closed mesh cut until no edge is longer, m; itself if it is no solid."""
    from manifold3d import Error

    solid = as_manifold(mesh)
    if solid.status() != Error.NoError:
        return mesh
    return from_manifold(solid.refine_to_length(length))
