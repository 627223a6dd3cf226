"""A stretch of space, and what it makes of points, shapes and inertias."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.vary.lock import matrix, quaternion

GEOM = mujoco.mjtGeom


@dataclass(frozen=True, kw_only=True)
class Affine:
    """The map x -> c + S (x - c), with S symmetric and positive."""

    S: Array
    """Stretch, shape (3, 3)."""
    c: Array
    """The point that stays, m, shape (3,)."""

    @property
    def uniform(self) -> bool:
        """Whether it stretches alike in all directions."""
        return bool((self.S[0, 0] * np.eye(3) == self.S).all())

    def point(self, x: Array) -> Array:
        """Return where a point goes, shape (3,)."""
        moved: Array = self.c + self.S @ (np.asarray(x) - self.c)
        return moved

    def along(self, axis: Array) -> float:
        """Return by what a length along an axis is multiplied."""
        return float(np.linalg.norm(self.S @ axis) / np.linalg.norm(axis))

    def frame(self, turn: Array) -> tuple[Array, Array]:
        """Return what becomes of a frame: factors along its axes, and its new rotation.

        Exact where its axes are axes of S. Elsewhere a right angle would not
        stay one: the z axis goes where S takes it, x and y stay square to it.

        Args:
            turn: The frame's quaternion w, x, y, z.
        """
        if self.uniform:
            return np.full(3, self.S[0, 0]), np.asarray(turn, dtype=float).copy()
        moved = self.S @ matrix(turn)
        factors: Array = np.linalg.norm(moved, axis=0)
        z = moved[:, 2] / factors[2]
        x = moved[:, 0] - z * (z @ moved[:, 0])
        x /= np.linalg.norm(x)
        return factors, quaternion(np.stack((x, np.cross(z, x), z), axis=1))


def stretch_shape(spec: Any, shape: Any, by: Affine) -> None:
    """Stretch a geom or a site; a round one stays round, with its volume.

    A sphere's radius, and that of a capsule or cylinder, is multiplied by the
    geometric mean of the factors that apply to it.
    """
    factors, turn = by.frame(shape.quat)
    shape.pos, shape.quat = by.point(shape.pos), turn
    size = np.array(shape.size)
    if shape.type == GEOM.mjGEOM_MESH:
        mesh = _own_mesh(spec, shape)
        mesh.scale = np.array(mesh.scale) * factors
    elif shape.type == GEOM.mjGEOM_SPHERE:
        size *= factors[0] if by.uniform else np.cbrt(np.prod(factors))
    elif shape.type in (GEOM.mjGEOM_CAPSULE, GEOM.mjGEOM_CYLINDER):
        size[0] *= factors[0] if by.uniform else np.sqrt(factors[0] * factors[1])
        size[1] *= factors[2]
    elif shape.type in (GEOM.mjGEOM_BOX, GEOM.mjGEOM_ELLIPSOID):
        size *= factors
    shape.size = size


def _own_mesh(spec: Any, geom: Any) -> Any:
    # Other links may draw the same mesh, and they are not stretched.
    mesh = spec.mesh(geom.meshname)
    users = [each for each in spec.geoms if each.meshname == geom.meshname]
    if len(users) == 1:
        return mesh
    taken = {each.name for each in spec.meshes}
    number = next(n for n in range(2, len(taken) + 3) if f"{geom.meshname}_{n}" not in taken)
    copy = spec.add_mesh(name=f"{geom.meshname}_{number}")
    for field in _MESH_FIELDS:
        setattr(copy, field, getattr(mesh, field))
    geom.meshname = copy.name
    return copy


_MESH_FIELDS = (
    "content_type", "file", "inertia", "maxhullvert", "refpos", "refquat", "scale", "smoothnormal",
    "userface", "userfacenormal", "userfacetexcoord", "usernormal", "usertexcoord", "uservert",
)  # fmt: skip
"""What makes a mesh, but its name."""
