"""The shapes of a robot's links that water touches, as meshes in the links' frames."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.physics.fluid.wetted.tessellate import (
    box_mesh,
    capsule_mesh,
    cylinder_mesh,
    ellipsoid_mesh,
)


def shapes_of(
    robot: Robot, link: str, *, drawn: bool = False, rigid: bool = False
) -> tuple[Mesh, ...]:
    """Return the shapes of one link that water touches, in its frame, m; maybe none.

    Args:
        robot: The robot.
        link: The link's name.
        drawn: Whether to take what is only drawn instead; see `every_shape`.
        rigid: Whether to take with it the links that no joint lets move against it.

    Raises:
        RobotError: There is no such link.
    """
    robot.link(link)
    return every_shape(robot, drawn=drawn, rigid=rigid).get(link, ())


def every_shape(
    robot: Robot, *, drawn: bool = False, rigid: bool = False
) -> dict[str, tuple[Mesh, ...]]:
    """Return the shapes that water touches of every link that has any, by its name.

    Those are the shapes that collide, or all of a link of which none does: what
    is only drawn beside them, as a deck or an eye, displaces nothing.

    Args:
        robot: The robot.
        drawn: Whether to take what is only drawn instead, where there is any.
        rigid: Whether links without a joint go to the link that carries them: the
            plates of a shell, each open, may bound a solid together.

    Returns:
        Meshes in the link's frame, m. A mesh file stays as it is, open or not.
    """
    model = bare_spec(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    results: dict[str, list[Mesh]] = {}
    for body in range(1, model.nbody):
        first = int(model.body_geomadr[body])
        geoms = np.arange(first, first + int(model.body_geomnum[body]))
        touching = (model.geom_contype[geoms] | model.geom_conaffinity[geoms]) != 0
        chosen = geoms[~touching] if drawn else geoms[touching]
        holder = _holder(model, body) if rigid else body
        turn, origin = data.xmat[holder].reshape(3, 3), data.xpos[holder]
        for geom in chosen if len(chosen) else geoms:
            mesh = _mesh_of(model, int(geom))
            if mesh is not None:
                seat = turn.T @ data.geom_xmat[geom].reshape(3, 3)
                place = turn.T @ (data.geom_xpos[geom] - origin)
                placed = Mesh(vertices=mesh.vertices @ seat.T + place, faces=mesh.faces)
                results.setdefault(model.body(holder).name, []).append(placed)
    return {name: tuple(meshes) for name, meshes in results.items()}


def _holder(model: Any, body: int) -> int:
    """Return the body that carries another without a joint between them."""
    while int(model.body_jntnum[body]) == 0 and int(model.body_parentid[body]) != 0:
        body = int(model.body_parentid[body])
    return body


def _mesh_of(model: Any, geom: int) -> Mesh | None:
    make = MAKERS.get(int(model.geom_type[geom]))
    return None if make is None else make(model, geom)


def _size(model: Any, geom: int) -> Array:
    return np.asarray(model.geom_size[geom], dtype=np.float64)


def _from_file(model: Any, geom: int) -> Mesh:
    # MuJoCo keeps a mesh about its own centre and axes; the geom's pose undoes that.
    mesh = int(model.geom_dataid[geom])
    corner, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    vertices = model.mesh_vert[corner : corner + int(model.mesh_vertnum[mesh])]
    faces = model.mesh_face[face : face + int(model.mesh_facenum[mesh])]
    return Mesh(vertices=vertices.astype(np.float64), faces=faces.astype(np.int64))


MAKERS: dict[int, Callable[[Any, int], Mesh]] = {
    int(mujoco.mjtGeom.mjGEOM_BOX): lambda m, g: box_mesh(2.0 * _size(m, g)),
    int(mujoco.mjtGeom.mjGEOM_SPHERE): lambda m, g: ellipsoid_mesh(np.full(3, _size(m, g)[0])),
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): lambda m, g: ellipsoid_mesh(_size(m, g)),
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): lambda m, g: cylinder_mesh(
        float(_size(m, g)[0]), 2.0 * float(_size(m, g)[1])
    ),
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): lambda m, g: capsule_mesh(
        float(_size(m, g)[0]), 2.0 * float(_size(m, g)[1])
    ),
    int(mujoco.mjtGeom.mjGEOM_MESH): _from_file,
}
"""What makes a mesh of each kind of shape; planes and fields of heights enclose nothing."""
