"""Reading the geometry of COLLADA (.dae)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from xml.etree import ElementTree

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh.fan import fans
from morph.body.mesh.gather import Gathering
from morph.body.mesh.limits import LARGEST, unreadable
from morph.body.mesh.numbers import floats, integers
from morph.body.mesh.solid import Mesh
from morph.body.xml import Element, parse
from morph.errors import MeshError, RobotError

MOST_ELEMENTS = 400_000
"""Most elements: some files have one for each polygon."""


def read_collada(content: bytes, where: str) -> Mesh:
    """Return what the scene of a COLLADA file shows, as one mesh, in metres.

    Read are meshes of triangles and polygons, under their nodes' transforms;
    skins, lights and materials are left out. The axis that the file calls up
    is not turned, as RViz does not turn it, for which URDFs are made.

    Source: COLLADA 1.4.1 specification, Khronos 2008.

    Raises:
        MeshError: It is not XML, or refers to what it does not hold.
    """
    try:
        tree = parse(content, where, most=LARGEST, elements=MOST_ELEMENTS)
        return _Scene(tree, where).mesh()
    except MeshError:
        raise
    except RobotError as error:
        raise unreadable(error.what, error.where) from error
    except (ValueError, KeyError, IndexError, OverflowError) as error:
        raise unreadable(f"cannot be read as COLLADA: {error!r}", where) from error


class _Scene:
    """Walks the nodes and gathers the triangles that they show."""

    def __init__(self, root: Element, where: str) -> None:
        self.root = root
        self.known = {e.get("id", ""): e for e in root.everything()}
        self.gathering = Gathering(where)
        self.read: dict[str, list[tuple[Array, Integers]]] = {}

    def mesh(self) -> Mesh:
        unit = self.root.find("asset/unit")
        metres = float(unit.get("meter", "1")) if unit is not None else 1.0
        place = np.diag((metres, metres, metres, 1.0))
        shown = self.root.find("scene/instance_visual_scene")
        if shown is not None:
            self._node(self._target(shown, "url"), place, 0)
        else:
            for geometry in self.root.iterfind("library_geometries/geometry"):
                self._show(geometry.get("id", ""), place)
        return self.gathering.mesh()

    def _target(self, element: ElementTree.Element, key: str) -> Element:
        return self.known[element.get(key, "").removeprefix("#")]

    def _node(self, node: Element, place: Array, depth: int) -> None:
        self.gathering.enter(depth)
        for child in node.children():
            if child.tag in TRANSFORMS:
                place = place @ TRANSFORMS[child.tag](_numbers(child))
        for child in node.children("node"):
            self._node(child, place, depth + 1)
        for child in node.children("instance_node"):
            self._node(self._target(child, "url"), place, depth + 1)
        for child in node.children("instance_geometry"):
            self._show(child.get("url", "").removeprefix("#"), place)

    def _show(self, name: str, place: Array) -> None:
        self.gathering.enter(0)
        if name not in self.read:
            mesh = self.known[name].child("mesh")
            self.read[name] = [] if mesh is None else list(self._triangles(mesh))
        for vertices, faces in self.read[name]:
            self.gathering.add(vertices, faces, place)

    def _triangles(self, mesh: Element) -> Iterator[tuple[Array, Integers]]:
        for primitive in mesh.children("triangles", "polylist", "polygons"):
            inputs = {each.get("semantic", ""): each for each in primitive.children("input")}
            stride = 1 + max(int(each.get("offset", "0")) for each in inputs.values())
            offset = int(inputs["VERTEX"].get("offset", "0"))
            positions = self._positions(self._target(inputs["VERTEX"], "source"))
            listed = [
                _integers(each).reshape(-1, stride)[:, offset] for each in primitive.children("p")
            ]
            corners = np.concatenate([np.zeros(0, dtype=np.int64), *listed])
            if primitive.tag == "triangles":
                yield positions, corners.reshape(-1, 3)
            elif primitive.tag == "polygons":
                yield positions, fans(corners, np.array([len(each) for each in listed], np.int64))
            else:
                yield positions, fans(corners, _integers(primitive.child("vcount")))

    def _positions(self, vertices: Element) -> Array:
        inputs = {each.get("semantic", ""): each for each in vertices.children("input")}
        source = self._target(inputs["POSITION"], "source")
        values = _numbers(source.child("float_array"))
        accessor = source.find("technique_common/accessor")
        stride = int(accessor.get("stride", "1")) if accessor is not None else 3
        if stride < 3:
            raise ValueError(f"positions have {stride} coordinates")
        rows: Array = values[: len(values) // stride * stride].reshape(-1, stride)[:, :3]
        return rows


def _numbers(element: Element | None) -> Array:
    return floats(element.text if element is not None else None)


def _integers(element: Element | None) -> Integers:
    return integers(element.text if element is not None else None)


def _moved(shift: Array) -> Array:
    place = np.eye(4)
    place[:3, 3] = shift
    return place


def _turned(numbers: Array) -> Array:
    # Rodrigues: R = I + sin(angle) K + (1 - cos(angle)) K K, K the cross product with the axis.
    x, y, z, degrees = numbers.tolist()
    length = math.hypot(x, y, z)
    if length == 0.0:
        return np.eye(4)
    axis = np.array((x, y, z)) / length
    cross = np.cross(np.eye(3), axis)  # Its rows, e x axis, are those of the matrix K.
    angle, place = math.radians(degrees), np.eye(4)
    place[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return place


def _stretched(factors: Array) -> Array:
    return np.diag((*factors, 1.0))


TRANSFORMS: dict[str, Callable[[Array], Array]] = {
    "matrix": lambda numbers: numbers.reshape(4, 4),
    "translate": _moved,
    "rotate": _turned,
    "scale": _stretched,
}
"""A node's transforms, each as a matrix of shape (4, 4)."""
