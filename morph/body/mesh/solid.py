"""A triangle mesh, and the facts of the solid that it encloses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh.merge import merged
from morph.errors import MeshError

NIL = 1e-12
"""Volume, as a part of the cube on the bounds' diagonal, below which there is none.

Rounding leaves about 1e-16 of it for each face that cancels another.
"""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """A triangle mesh; its facts are computed when first asked for, then kept.

    Integrals are those of the solid that the faces enclose, by the divergence
    theorem: a tetrahedron from one fixed point to each face, signed by the
    face's winding (Blow and Binstock 2004, "How to find the inertia tensor").
    They mean what they say for a mesh that is `watertight` and `consistent`;
    for any other they are what its faces add up to.
    """

    vertices: Array
    """Corners, shape (n, 3), in the units of the file."""
    faces: Integers
    """Triangles as indices of corners, counter-clockwise from outside, shape (m, 3)."""

    @cached_property
    def bounds(self) -> Array:
        """Least and greatest coordinates of the corners that faces use, shape (2, 3)."""
        used = self.vertices[self.faces.ravel()]
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @property
    def volume(self) -> float:
        """Signed volume; negative if the faces are inside out."""
        return self._moments[0]

    @property
    def hollow(self) -> bool:
        """Whether the faces enclose nothing, as those of a sheet do."""
        diagonal = float(np.linalg.norm(self.bounds[1] - self.bounds[0]))
        return abs(self.volume) <= NIL * diagonal**3

    @cached_property
    def com(self) -> Array:
        """Centre of the volume, shape (3,); of the surface's area if the mesh is `hollow`."""
        volume, first, _ = self._moments
        if not self.hollow:
            return self._middle + first / volume
        a, b, c = self._corners
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        if area.sum() == 0.0:
            return self._middle
        centre: Array = self._middle + area @ (a + b + c) / (3.0 * area.sum())
        return centre

    @cached_property
    def inertia(self) -> Array:
        """Inertia about `com` at density 1, shape (3, 3); zero if the mesh is `hollow`.

        Of a mesh that is inside out, that of the solid turned right side out.
        """
        volume, first, second = self._moments
        if self.hollow:
            return np.zeros((3, 3))
        spread = (second - np.outer(first, first) / volume) * np.sign(volume)
        about: Array = np.trace(spread) * np.eye(3) - spread
        return about

    @property
    def watertight(self) -> bool:
        """Whether each edge belongs to two faces, once identical corners are one.

        Faces that so lose a corner are left out: they bound nothing.
        """
        return self._edges[0]

    @property
    def consistent(self) -> bool:
        """Whether it is watertight, and the two faces at each edge wind the same way."""
        return self._edges[1]

    @cached_property
    def merged(self) -> Mesh:
        """The same surface with identical corners made one, and unused ones left out."""
        vertices, faces = merged(self.vertices, self.faces)
        return Mesh(vertices=vertices, faces=faces)

    @cached_property
    def hull(self) -> Mesh:
        """The convex hull, its faces wound outward.

        Raises:
            MeshError: The corners lie in one plane, so that there is none.
        """
        from scipy.spatial import ConvexHull, QhullError

        points = self.merged.vertices
        try:
            result = ConvexHull(points)
        except (QhullError, ValueError) as error:
            raise MeshError(
                f"its {len(points)} corners have no convex hull, as they lie in one plane",
                where="morph.body.mesh.Mesh.hull",
                fix="give a mesh that encloses a volume",
                code="mesh-empty",
            ) from error
        faces = np.asarray(result.simplices, dtype=np.int64)
        a, b, c = points[faces].transpose(1, 0, 2)
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), result.equations[:, :3]) < 0
        faces[inward] = faces[inward][:, ::-1]
        vertices, faces = merged(points, faces)
        return Mesh(vertices=vertices, faces=faces)

    def scaled(self, scale: Sequence[float] | float) -> Mesh:
        """Return it with each axis multiplied by a factor, about the origin.

        Args:
            scale: One factor, or one per axis. An odd number of negative ones
                mirrors the mesh; its faces are then wound the other way, so
                that outside stays outside and the volume keeps its sign.
        """
        factors = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,))
        mirrored = np.prod(np.sign(factors)) < 0
        return Mesh(
            vertices=self.vertices * factors,
            faces=self.faces[:, ::-1].copy() if mirrored else self.faces,
        )

    @cached_property
    def _middle(self) -> Array:
        # Moments are taken about the middle: far from the origin they would
        # be small differences of large numbers.
        middle: Array = self.bounds.mean(axis=0)
        return middle

    @property
    def _corners(self) -> tuple[Array, Array, Array]:
        centred = self.vertices - self._middle
        return centred[self.faces[:, 0]], centred[self.faces[:, 1]], centred[self.faces[:, 2]]

    @cached_property
    def _moments(self) -> tuple[float, Array, Array]:
        # Volume, and first and second moments about the middle. With corners
        # a, b, c of a face and d = a . (b x c): d / 6, d (a + b + c) / 24 and
        # d (s s' + a a' + b b' + c c') / 120 with s = a + b + c.
        a, b, c = self._corners
        d = np.einsum("ij,ij->i", a, np.cross(b, c))[:, None]
        s = a + b + c
        second = sum((d * x).T @ x for x in (s, a, b, c)) / 120.0
        return float(d.sum()) / 6.0, (d * s).sum(axis=0) / 24.0, np.asarray(second)

    @cached_property
    def _edges(self) -> tuple[bool, bool]:
        faces, count = self.merged.faces, len(self.merged.vertices)
        whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        start = faces[whole].ravel()
        end = np.roll(faces[whole], -1, axis=1).ravel()
        # The lowest bit tells which way a face runs along the edge.
        low, high = np.minimum(start, end), np.maximum(start, end)
        key = np.sort((low * count + high) * 2 + (start < end))
        if len(key) == 0 or len(key) % 2:
            return False, False
        pair = (key >> 1).reshape(-1, 2)
        closed = bool((pair[:, 0] == pair[:, 1]).all() and (pair[1:, 0] != pair[:-1, 0]).all())
        return closed, closed and bool((key.reshape(-1, 2) & 1 == (0, 1)).all())
