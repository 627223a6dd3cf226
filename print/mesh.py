"""A triangle mesh in millimetres, and the solid that it encloses."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from morph.print.arrays import Array, Integers
from morph.print.errors import SolidError


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """A triangle mesh; its facts are computed when first asked for, then kept."""

    vertices: Array
    """Corners, mm, shape (n, 3)."""
    faces: Integers
    """Triangles as indices of corners, counter-clockwise from outside, shape (m, 3)."""

    @cached_property
    def bounds(self) -> Array:
        """Least and greatest coordinates, mm, shape (2, 3)."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def extent(self) -> Array:
        """Length along each axis, mm, shape (3,)."""
        size: Array = self.bounds[1] - self.bounds[0]
        return size

    @property
    def corners(self) -> Array:
        """Corners of each triangle, mm, shape (m, 3, 3)."""
        points: Array = self.vertices[self.faces]
        return points

    @cached_property
    def volume(self) -> float:
        """Signed volume by the divergence theorem, mm3; negative if the faces are inside out."""
        a, b, c = (self.corners - self.bounds.mean(axis=0)).transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @cached_property
    def sha256(self) -> str:
        """Hash of its corners, to a nanometre, and of its triangles."""
        corners = np.round(self.vertices * 1e6).astype("<i8")
        return hashlib.sha256(corners.tobytes() + self.faces.astype("<i8").tobytes()).hexdigest()

    @cached_property
    def manifold(self) -> Any:
        """The solid as a `manifold3d.Manifold`, to cut and join.

        Raises:
            SolidError: The mesh encloses no solid; what is said names manifold3d's reason.
        """
        import manifold3d

        result = manifold3d.Manifold(
            manifold3d.Mesh64(
                np.ascontiguousarray(self.vertices, dtype=np.float64),
                np.ascontiguousarray(self.faces, dtype=np.uint64),
            )
        )
        if result.status() != manifold3d.Error.NoError or result.is_empty():
            reason = str(result.status()).rpartition(".")[2]
            raise SolidError(
                f"the mesh encloses no solid ({'Empty' if reason == 'NoError' else reason})",
                where="morph.print.mesh.Mesh.manifold",
                fix="close its surface, with each edge between two faces that wind alike",
            )
        return result

    @cached_property
    def trimesh(self) -> Any:
        """The same corners and triangles as a `trimesh.Trimesh`, nothing merged or repaired."""
        import trimesh

        return trimesh.Trimesh(vertices=self.vertices, faces=self.faces, process=False)

    def moved(self, pose: Array) -> Mesh:
        """Return the mesh under a transform, shape (4, 4), mm; a mirror turns its faces over."""
        mirrored = np.linalg.det(pose[:3, :3]) < 0
        return Mesh(
            vertices=self.vertices @ pose[:3, :3].T + pose[:3, 3],
            faces=self.faces[:, ::-1].copy() if mirrored else self.faces,
        )


def from_manifold(solid: Any) -> Mesh:
    """Return the surface of a `manifold3d.Manifold`, its coinciding corners one.

    Raises:
        SolidError: The solid is empty, or an operation on it failed.
    """
    import manifold3d

    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        raise SolidError(
            f"nothing is left of the solid ({str(solid.status()).rpartition('.')[2]})",
            where="morph.print.mesh.from_manifold",
            fix="see that what is joined is solid, and that a cut does not take all of it",
        )
    surface = solid.to_mesh64()
    return Mesh(
        vertices=np.array(surface.vert_properties[:, :3], dtype=np.float64),
        faces=np.array(surface.tri_verts, dtype=np.int64),
    )


def joined(meshes: Iterable[Mesh]) -> Mesh:
    """Return the union of solids.

    Raises:
        SolidError: One of them is no solid, or there is none.
    """
    import manifold3d

    solids = [mesh.manifold for mesh in meshes]
    return from_manifold(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add))
