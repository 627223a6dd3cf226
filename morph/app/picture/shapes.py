"""A model's shapes as triangles, for what draws triangles only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from morph.arrays import Array, Integers

SHOWN_GROUPS = 3
"""Geoms of lower groups are drawn; the others are for collisions only, by MuJoCo's custom."""


@dataclass(frozen=True, kw_only=True)
class PictureShape:
    """One geom."""

    body: int
    """The body that it is fixed to; 0 is the world."""
    vertices: Array
    """In the body's frame, m, shape (vertices, 3)."""
    faces: Integers
    """Three vertices each, shape (faces, 3)."""
    colour: tuple[int, int, int]
    """Red, green and blue, 0 to 255."""
    opacity: float
    """From 0, invisible, to 1."""
    flat: bool
    """Whether its faces are to be seen."""
    colours: NDArray[np.uint8] | None = None
    """Of each vertex, instead of `colour`, shape (vertices, 3); what is merged or thinned has
    none."""


def shapes(model: Any, groups: int = SHOWN_GROUPS) -> Iterator[PictureShape]:
    """Yield all shapes of a `mujoco.MjModel` that have an end and are drawn.

    Args:
        model: The model.
        groups: How many groups of geoms are drawn, 0 to 6.
    """
    for geom in range(model.ngeom):
        if model.geom_group[geom] >= groups:
            continue
        solid = _solid(model, geom)
        if solid is None:
            continue
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        material = int(model.geom_matid[geom])
        rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
        red, green, blue = (round(255 * float(value)) for value in rgba[:3])
        yield PictureShape(
            body=int(model.geom_bodyid[geom]),
            vertices=solid[0] @ turn.reshape(3, 3).T + model.geom_pos[geom],
            faces=solid[1],
            colour=(red, green, blue),
            opacity=float(rgba[3]),
            flat=model.geom_type[geom]
            in (mujoco.mjtGeom.mjGEOM_BOX.value, mujoco.mjtGeom.mjGEOM_MESH.value),
        )


def _solid(model: Any, geom: int) -> tuple[Array, Integers] | None:
    """Return vertices and faces in the geom's own frame; None for a plane or hills."""
    from trimesh import creation

    kinds = mujoco.mjtGeom
    kind, size = kinds(model.geom_type[geom]), model.geom_size[geom]
    if kind in (kinds.mjGEOM_MESH, kinds.mjGEOM_SDF):
        return _mesh(model, int(model.geom_dataid[geom]))
    if kind == kinds.mjGEOM_BOX:
        solid = creation.box(2.0 * size)
    elif kind in (kinds.mjGEOM_SPHERE, kinds.mjGEOM_ELLIPSOID):
        solid = creation.icosphere(subdivisions=2)
        solid.vertices *= size if kind == kinds.mjGEOM_ELLIPSOID else size[0]
    elif kind == kinds.mjGEOM_CAPSULE:
        # Its height is that of the cylinder between the two round ends.
        solid = creation.capsule(radius=size[0], height=2.0 * size[1], count=[16, 16])
        solid.vertices -= solid.bounds.mean(axis=0)
    elif kind == kinds.mjGEOM_CYLINDER:
        solid = creation.cylinder(radius=size[0], height=2.0 * size[1], sections=32)
    else:
        return None
    return np.asarray(solid.vertices, dtype=float), np.asarray(solid.faces, dtype=np.int64)


def _mesh(model: Any, mesh: int) -> tuple[Array, Integers]:
    corner, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    corners, faces = int(model.mesh_vertnum[mesh]), int(model.mesh_facenum[mesh])
    return (
        np.array(model.mesh_vert[corner : corner + corners], dtype=float),
        np.array(model.mesh_face[face : face + faces], dtype=np.int64),
    )
