"""What a description draws of each link, as solids in millimetres, and where the links stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.mesh import read_mesh
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.errors import MeshError
from morph.fabrication.solids import placed, solid
from morph.print.mesh import Mesh

SHOWN_GROUPS = 3
"""Geoms of lower groups are drawn; the others are for collisions only, by MuJoCo's custom."""

MM = 1e3
"""One metre, mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkShape:
    """One shape of a link."""

    name: str
    """Its name in the description; may be empty."""
    link: str
    """The link that it belongs to."""
    kind: str
    """`mesh`, `box`, `sphere`, `ellipsoid`, `cylinder` or `capsule`."""
    mesh: Mesh
    """Its surface in its own frame, mm."""
    pose: Array
    """From its own frame into the link's, shape (4, 4), mm."""
    size: Array
    """MuJoCo's halves, mm, shape (3,); of a mesh, half its extent."""
    file: str = ""
    """The file that it comes from, if it is a mesh."""

    @property
    def placed(self) -> Mesh:
        """The surface in the link's frame."""
        return self.mesh.moved(self.pose)


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """A body as it is drawn, with all joints at zero."""

    robot: Robot
    """The body."""
    model: Any
    """It as a `mujoco.MjModel`."""
    data: Any
    """Where everything is at zero: a `mujoco.MjData`."""
    shapes: Mapping[str, tuple[LinkShape, ...]]
    """What is drawn of each link."""
    unread: tuple[str, ...]
    """What could not be read, in words."""

    def world(self, link: str) -> Array:
        """Return where a link stands in the world, shape (4, 4), mm."""
        body = self.model.body(link).id
        return placed(self.data.xmat[body], MM * self.data.xpos[body])


def drawing(robot: Robot) -> Drawing:
    """Return a body's shapes, those that are drawn, exactly as their files have them."""
    spec = bare_spec(robot)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    files = _Files(robot, spec)
    shapes: dict[str, list[LinkShape]] = {link.name: [] for link in robot.links}
    for geom in range(model.ngeom):
        link = model.body(int(model.geom_bodyid[geom])).name
        if model.geom_group[geom] < SHOWN_GROUPS and link in shapes:
            result = _drawn(model, geom, link, files)
            shapes[link] += [result] if result is not None else []
    return Drawing(
        robot=robot,
        model=model,
        data=data,
        shapes={link: tuple(result) for link, result in shapes.items()},
        unread=tuple(files.unread),
    )


def _drawn(model: Any, geom: int, link: str, files: _Files) -> LinkShape | None:
    kinds = mujoco.mjtGeom
    kind = kinds(model.geom_type[geom])
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    pose = placed(turn, MM * model.geom_pos[geom])
    name, file = model.geom(geom).name, ""
    if kind in (kinds.mjGEOM_MESH, kinds.mjGEOM_SDF):
        at = int(model.geom_dataid[geom])
        mesh, file = files.mesh(model, at)
        size = mesh.extent / 2.0
        # MuJoCo moves a mesh to its middle; this undoes it.
        mujoco.mju_quat2Mat(turn, model.mesh_quat[at])
        pose = pose @ np.linalg.inv(placed(turn, MM * model.mesh_pos[at]))
        word = "mesh"
    else:
        word = kind.name.removeprefix("mjGEOM_").lower()
        size = MM * model.geom_size[geom]
        result = solid(word, size)
        if result is None:
            return None
        mesh = result
    return LinkShape(name=name, link=link, kind=word, mesh=mesh, pose=pose, size=size, file=file)


class _Files:
    """Reads each mesh once, in the frame that its asset states."""

    def __init__(self, robot: Robot, spec: Any) -> None:
        self.robot = robot
        self.assets = {mesh.name: mesh for mesh in spec.meshes}
        self.read: dict[int, tuple[Mesh, str]] = {}
        self.unread: list[str] = []

    def mesh(self, model: Any, at: int) -> tuple[Mesh, str]:
        if at not in self.read:
            self.read[at] = self._mesh(model, at)
        return self.read[at]

    def _mesh(self, model: Any, at: int) -> tuple[Mesh, str]:
        asset = self.assets.get(model.mesh(at).name)
        file = "" if asset is None else asset.file
        content = self.robot.assets.get(file) if file else None
        if asset is None or content is None:
            return _compiled(model, at), file
        try:
            result = read_mesh(content, Path(file).suffix, file).merged
        except MeshError as error:
            self.unread.append(f"{file}: {error.what}; MuJoCo's copy of it was taken")
            return _compiled(model, at), file
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, np.asarray(asset.refquat) / np.linalg.norm(asset.refquat))
        stated = (result.vertices - np.asarray(asset.refpos)) @ turn.reshape(3, 3)
        scale = np.asarray(asset.scale)
        mirrored = bool(np.prod(scale) < 0)
        return Mesh(
            vertices=MM * stated * scale,
            faces=result.faces[:, ::-1].copy() if mirrored else result.faces,
        ), file


def _compiled(model: Any, at: int) -> Mesh:
    """Return a mesh as MuJoCo holds it, back in the frame of its asset."""
    corner, face = int(model.mesh_vertadr[at]), int(model.mesh_faceadr[at])
    corners, faces = int(model.mesh_vertnum[at]), int(model.mesh_facenum[at])
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[at])
    held = np.asarray(model.mesh_vert[corner : corner + corners], dtype=np.float64)
    return Mesh(
        vertices=MM * held,
        faces=np.array(model.mesh_face[face : face + faces], dtype=np.int64),
    ).moved(placed(turn, MM * model.mesh_pos[at]))
