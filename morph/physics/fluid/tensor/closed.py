"""Whether a mesh encloses a volume of fluid that it displaces, and why not."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh
from morph.errors import RobotError


def closed_solid(vertices: ArrayLike, faces: ArrayLike) -> Mesh:
    """Return the mesh with identical corners made one, if it is a solid in a fluid.

    Raises:
        RobotError: A corner is missing or not finite; the mesh is open, wound both
            ways, without volume, inside out, or has a cavity.
    """
    mesh = _arrays(vertices, faces).merged
    if not mesh.watertight:
        raise _refused("its surface is open: some edges do not have two faces", _CLOSE)
    if not mesh.consistent:
        raise _refused("some neighbouring faces are wound opposite ways", _WIND)
    if mesh.hollow:
        raise _refused("it encloses no volume", "give a solid, or a plate with its thickness")
    if mesh.volume < 0.0:
        raise _refused(f"it is inside out: its volume is {mesh.volume:.4g} m3", _WIND)
    volumes = piece_volumes(mesh)
    if volumes.min() < 0.0:
        raise _refused(
            f"{(volumes < 0.0).sum()} of its {len(volumes)} pieces are inside out: cavities, or "
            "solids wound the wrong way",
            "leave out inner surfaces, which the fluid does not reach, and wind every face "
            "counter-clockwise from outside",
        )
    return mesh


def piece_volumes(mesh: Mesh) -> Array:
    """Return the signed volume of each connected piece, shape (pieces,), m3."""
    # Loads a library that few need.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    start, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    count = len(mesh.vertices)
    graph = coo_array((np.ones(len(start)), (start, end)), shape=(count, count))
    pieces, label = connected_components(graph, directed=False)
    a, b, c = (mesh.vertices - mesh.com)[mesh.faces].transpose(1, 0, 2)
    signed = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volumes: Array = np.zeros(pieces)
    np.add.at(volumes, label[mesh.faces[:, 0]], signed)
    return volumes


_CLOSE = "close the mesh, wrap it, or take its convex hull"
_WIND = "wind every face counter-clockwise from outside"


def _arrays(vertices: ArrayLike, faces: ArrayLike) -> Mesh:
    corners = np.asarray(vertices, dtype=np.float64)
    triangles: Integers = np.asarray(faces, dtype=np.int64)
    if (
        corners.ndim != 2
        or triangles.ndim != 2
        or corners.shape[1:] + triangles.shape[1:] != (3, 3)
    ):
        raise _refused(
            f"vertices of shape {corners.shape} and faces of shape {triangles.shape} are no mesh",
            "give shapes (n, 3) and (m, 3)",
        )
    if not triangles.size:
        raise _refused("it has no faces", _CLOSE)
    if not (0 <= triangles.min() <= triangles.max() < len(corners)):
        raise _refused(
            f"its faces name corners {triangles.min()} to {triangles.max()} of {len(corners)}",
            "give indices of corners, from 0",
        )
    if not np.isfinite(corners).all():
        raise _refused("a corner is not a finite number", "give finite coordinates, in metres")
    return Mesh(vertices=corners, faces=triangles)


def _refused(what: str, fix: str) -> RobotError:
    return RobotError(what, where="morph.physics.fluid.tensor: the mesh", fix=fix)
