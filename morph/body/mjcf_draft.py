"""A draft of what MuJoCo made of an MJCF, so that the same checks look at it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.body.draft import Draft, DraftJoint, DraftLink, Pose, Shape
from morph.body.finding import Where
from morph.body.mesh import Mesh
from morph.body.robot import Robot
from morph.body.xml import Element

KINDS = {
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}
"""Geoms that a draft can hold; planes and height fields are the world's."""

SHOWN = 2
"""Last group of geoms that MuJoCo's viewers show unasked."""

JOINTS = {
    mujoco.mjtJoint.mjJNT_FREE: "floating",
    mujoco.mjtJoint.mjJNT_BALL: "ball",
    mujoco.mjtJoint.mjJNT_SLIDE: "prismatic",
    mujoco.mjtJoint.mjJNT_HINGE: "revolute",
}
"""What URDF calls MuJoCo's joints."""


class ElementLines:
    """Where in its file each named element stands."""

    def __init__(self, tree: Element, path: Path) -> None:
        self.file = str(path)
        self.known: dict[tuple[str, str], Element] = {}
        self.add(tree)

    def add(self, tree: Element) -> None:
        """Take in the elements of a file that the first one includes."""
        for element in tree.everything():
            tag = "joint" if element.tag == "freejoint" else element.tag
            if name := element.get("name"):
                self.known.setdefault((tag, name), element)

    def place(self, tag: str, name: str) -> Where:
        """Return the place of an element, as a finding names it."""
        element = self.known.get((tag, name))
        kind = "link" if tag == "body" else tag
        if element is None:
            return Where(kind=kind, name=name, file=self.file)
        return Where(kind=kind, name=name, file=element.file, line=element.line)


def draft_of(robot: Robot, model: Any, path: Path, lines: ElementLines) -> Draft:
    """Return a robot's draft: masses and shapes as MuJoCo compiled them."""
    meshes: dict[int, Mesh] = {}
    links, joints = [], []
    for body in range(1, model.nbody):
        name = model.body(body).name
        link = robot.links[body - 1]
        xx, yy, zz, xy, xz, yz = link.inertia
        links.append(
            DraftLink(
                name=name,
                mass=link.mass,
                com=np.array(link.com),
                inertia=np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
                shapes=_shapes(model, body, meshes),
                line=lines.place("body", name).line,
            )
        )
        joints += _joints(model, body, lines)
    return Draft(name=robot.name, file=path, links=tuple(links), joints=tuple(joints))


def _pose(position: Any, quaternion: Any) -> Pose:
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, quaternion)
    return Pose(position=np.array(position), rotation=turn.reshape(3, 3))


def _shapes(model: Any, body: int, meshes: dict[int, Mesh]) -> tuple[Shape, ...]:
    shapes = []
    first = model.body_geomadr[body]
    for geom in range(first, first + model.body_geomnum[body]):
        kind = KINDS.get(mujoco.mjtGeom(model.geom_type[geom]))
        if kind is None:
            continue
        size = model.geom_size[geom]
        shapes += [
            Shape(
                role=role,
                kind=kind,
                pose=_pose(model.geom_pos[geom], model.geom_quat[geom]),
                size={
                    "box": tuple((2 * size).tolist()),
                    "sphere": (float(size[0]),),
                    "mesh": (),
                }.get(kind, (float(size[0]), 2 * float(size[1]))),
                file=model.mesh(model.geom_dataid[geom]).name if kind == "mesh" else "",
                mesh=_mesh(model, int(model.geom_dataid[geom]), meshes) if kind == "mesh" else None,
            )
            for role in roles(model, geom)
        ]
    return tuple(shapes)


def roles(model: Any, geom: int) -> list[str]:
    """Return `visual`, `collision` or both.

    What MuJoCo's viewers show is meant to be seen, whether it touches or not.
    """
    touches = model.geom_contype[geom] or model.geom_conaffinity[geom]
    shown = not touches or model.geom_group[geom] <= SHOWN
    return ["visual"] * bool(shown) + ["collision"] * bool(touches)


def _mesh(model: Any, mesh: int, meshes: dict[int, Mesh]) -> Mesh:
    # One object a mesh, so that what is computed of it is computed once.
    if mesh not in meshes:
        vertex, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
        meshes[mesh] = Mesh(
            vertices=model.mesh_vert[vertex : vertex + model.mesh_vertnum[mesh]].astype(float),
            faces=model.mesh_face[face : face + model.mesh_facenum[mesh]].astype(np.int64),
        )
    return meshes[mesh]


def _joints(model: Any, body: int, lines: ElementLines) -> list[DraftJoint]:
    name, parent = model.body(body).name, model.body(model.body_parentid[body]).name
    pose = _pose(model.body_pos[body], model.body_quat[body])
    first, count = model.body_jntadr[body], model.body_jntnum[body]
    if parent == "world":
        return []  # A draft's roots hang from nothing.
    if not count:
        return [DraftJoint(name=f"to {name}", kind="fixed", parent=parent, child=name, pose=pose)]
    # A draft has one joint a link: of several, the last, which carries the link.
    joint = first + count - 1
    title = model.joint(joint).name
    return [
        DraftJoint(
            name=title,
            kind=JOINTS[mujoco.mjtJoint(model.jnt_type[joint])],
            parent=parent,
            child=name,
            pose=pose,
            axis=np.array(model.jnt_axis[joint]),
            line=lines.place("joint", title).line,
        )
    ]
