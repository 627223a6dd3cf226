"""The shapes of a compiled MuJoCo model as URDF's, with their mesh files; and its numbers."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh, as_stl
from morph.body.mjcf_draft import roles

LONGEST_STEM = 60
"""Letters of a file's name without its ending; file systems take 255 bytes."""


class Shapes:
    """Writes the geoms of a body into a link, and keeps the mesh files that it names."""

    def __init__(self, model: Any, meshes: str) -> None:
        self.model, self.meshes = model, meshes
        self.assets: dict[str, bytes] = {}
        self.left_out: list[str] = []

    def add(self, link: ElementTree.Element, body: int, anchor: Array) -> None:
        """Add a body's shapes to a link whose frame is shifted to an anchor, m."""
        model = self.model
        first = model.body_geomadr[body]
        for geom in range(first, first + model.body_geomnum[body]) if first >= 0 else ():
            turn = matrix(model.geom_quat[geom])
            place = model.geom_pos[geom] - anchor
            for role in roles(model, geom):
                for shape, along in self._primitives(geom):
                    element = ElementTree.SubElement(link, role)
                    origin(element, place + turn @ np.array((0.0, 0.0, along)), turn)
                    ElementTree.SubElement(element, "geometry").append(shape)
                    if role == "visual":
                        self._colour(element, geom)

    def _primitives(self, geom: int) -> list[tuple[ElementTree.Element, float]]:
        """Return a geom as URDF's shapes, each with its height along the geom's axis."""
        model, element = self.model, ElementTree.Element
        a, b, c = model.geom_size[geom].tolist()
        kind = mujoco.mjtGeom(model.geom_type[geom])
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            return [(element("box", size=numbers((2 * a, 2 * b, 2 * c))), 0.0)]
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            return [(element("sphere", radius=number(a)), 0.0)]
        if kind in (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE):
            parts = [(element("cylinder", radius=number(a), length=number(2 * b)), 0.0)]
            if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
                parts += [(element("sphere", radius=number(a)), end) for end in (-b, b)]
            return parts
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            return [(element("mesh", filename=self._mesh(int(model.geom_dataid[geom]))), 0.0)]
        if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            file = f"ellipsoid_{geom}.stl"
            self.assets[file] = as_stl(ellipsoid(a, b, c))
            return [(element("mesh", filename=f"{self.meshes}/{file}"), 0.0)]
        self.left_out.append(f"a shape of the kind {kind.name.removeprefix('mjGEOM_').lower()}")
        return []

    def _mesh(self, mesh: int) -> str:
        model = self.model
        vertex, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
        file = file_name(f"{mesh}_{model.mesh(mesh).name}", ".stl")
        if file not in self.assets:
            vertices = model.mesh_vert[vertex : vertex + model.mesh_vertnum[mesh]]
            faces = model.mesh_face[face : face + model.mesh_facenum[mesh]]
            self.assets[file] = as_stl(
                Mesh(vertices=vertices.astype(float), faces=faces.astype(np.int64))
            )
        return f"{self.meshes}/{file}"

    def _colour(self, element: ElementTree.Element, geom: int) -> None:
        model = self.model
        held = model.geom_matid[geom]
        rgba = model.geom_rgba[geom] if held < 0 else model.mat_rgba[held]
        material = ElementTree.SubElement(element, "material", name=f"colour_{geom}")
        ElementTree.SubElement(material, "color", rgba=numbers(rgba))


def file_name(stem: str, ending: str) -> str:
    """Return a name that every file system and every reader of descriptions takes."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", stem)[:LONGEST_STEM] + ending


def ellipsoid(a: float, b: float, c: float) -> Mesh:
    """Return an ellipsoid's mesh of 16 by 8 patches, with the half axes a, b and c."""
    turns, rises = np.linspace(0, 2 * np.pi, 17)[:-1], np.linspace(-np.pi / 2, np.pi / 2, 9)
    rows = [
        [(np.cos(r) * np.cos(t), np.cos(r) * np.sin(t), np.sin(r)) for t in turns] for r in rises
    ]
    points = np.array(rows).reshape(-1, 3) * (a, b, c)
    index = np.arange(9 * 16).reshape(9, 16)
    low, high = index[:-1], index[1:]
    right, above = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    first = np.stack([low, right, above], axis=-1)[1:].reshape(-1, 3)
    second = np.stack([low, above, high], axis=-1)[:-1].reshape(-1, 3)
    return Mesh(vertices=points, faces=np.concatenate([first, second]))


def matrix(quaternion: Array) -> Array:
    """Return a quaternion w, x, y, z as a rotation matrix, shape (3, 3)."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, quaternion)
    return turn.reshape(3, 3)


def angles(turn: Array) -> tuple[float, float, float]:
    """Return a rotation matrix as URDF's roll, pitch and yaw, rad.

    The inverse of `morph.body.numbers.rotation`, R = Rz(yaw) Ry(pitch) Rx(roll). Where
    x points straight up or down, yaw is any angle: so roll is read off what is left
    once yaw is taken away, and their errors cancel however near to that it is.
    """
    yaw = math.atan2(turn[1, 0], turn[0, 0])
    pitch = math.atan2(-turn[2, 0], math.hypot(turn[0, 0], turn[1, 0]))
    _, cosine, sine = -math.sin(yaw) * turn[0] + math.cos(yaw) * turn[1]
    return math.atan2(-sine, cosine), pitch, yaw


def origin(element: ElementTree.Element, place: Array, turn: Array) -> None:
    """Add an `<origin>`."""
    held = {"xyz": numbers(place), "rpy": numbers(angles(turn))}
    ElementTree.SubElement(element, "origin", held)


def number(value: float) -> str:
    """Return a number from whose text the same double comes back."""
    return repr(float(value) + 0.0)


def numbers(values: Any) -> str:
    """Return numbers, with a space between them."""
    return " ".join(number(value) for value in values)
