"""A mesh of evenly sized triangles on the faces of a polyhedron, whose edges stay."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.body.mesh import Mesh
from morph.errors import RobotError

SAG = 8.0
"""An arc of chord L on a circle of diameter d stands off by L^2 / (4 d); half is allowed."""

HALVINGS = 14
"""Halvings of the interval of edge lengths: 1000 to 1 becomes 1.0004 to 1."""


def even(solid: Mesh, panels: int) -> Mesh:
    """Return a mesh of at most about so many triangles of about one size.

    Corners that matter less than the size of a triangle are left out; long edges
    are divided. Edges and corners of a coarse polyhedron stay where they are.

    Raises:
        RobotError: The solid cannot be remeshed.
    """
    manifold = _manifold(solid)
    size = float(np.linalg.norm(solid.bounds[1] - solid.bounds[0]))
    low, high = 1e-3 * size, size
    for _ in range(HALVINGS):
        length = (low * high) ** 0.5
        if _sized(manifold, length, size).num_tri() > panels:
            low = length
        else:
            high = length
    made = _sized(manifold, high, size).to_mesh64()
    return Mesh(
        vertices=np.array(made.vert_properties[:, :3], dtype=np.float64),
        faces=np.array(made.tri_verts, dtype=np.int64),
    )


def _sized(manifold: Any, length: float, size: float) -> Any:
    return manifold.simplify(length**2 / (SAG * size)).refine_to_length(length)


def _manifold(solid: Mesh) -> Any:
    # Loads a library that only this needs.
    import manifold3d

    made = manifold3d.Manifold(
        manifold3d.Mesh64(
            vert_properties=np.ascontiguousarray(solid.vertices),
            tri_verts=np.ascontiguousarray(solid.faces, dtype=np.uint64),
        )
    )
    if made.status() != manifold3d.Error.NoError:
        raise RobotError(
            f"its {len(solid.faces)} faces cannot be remeshed: {made.status().name}",
            where="morph.physics.fluid.tensor: the mesh",
            fix="give a closed surface in which each edge has two faces, or its convex hull",
        )
    return made
