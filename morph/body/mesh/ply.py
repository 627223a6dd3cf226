"""Reading the corners and faces of PLY, ASCII and binary."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh.fan import fans
from morph.body.mesh.limits import FACES, too_large, unreadable
from morph.body.mesh.solid import Mesh

WHOLE = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
}
"""NumPy's name for each type of whole numbers that a PLY file may declare."""

TYPES = {
    **WHOLE,
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
"""NumPy's name for each type."""

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

LINE = re.compile(rb"[^\n]*\n")


@dataclass(frozen=True, kw_only=True)
class _Element:
    name: str
    count: int
    properties: tuple[tuple[str, ...], ...]
    """Each (type, name) or ("list", type of the count, type of the items, name)."""


def read_ply(content: bytes, where: str) -> Mesh:
    """Return the mesh in a PLY file; a polygon is cut from its first corner.

    Raises:
        MeshError: The header cannot be read, or promises what does not follow.
    """
    try:
        order, elements, start = _header(content)
        _check_counts(elements, len(content), where)
        if order:
            return _binary(content, start, order, elements)
        return _ascii(content, start, elements)
    except (ValueError, IndexError, KeyError, OverflowError) as error:
        words = str(error) or "its header is not that of PLY"
        raise unreadable(f"cannot be read as PLY: {words}", where) from error


def _header(content: bytes) -> tuple[str, list[_Element], int]:
    order, elements, at = "", [], 0
    for result in LINE.finditer(content, 0, 65536):
        words = result.group().decode("ascii", "replace").split()
        at = result.end()
        if result.start() == 0 and words != ["ply"]:
            raise ValueError("it does not begin with ply")
        if words[:1] == ["format"]:
            order = ORDERS[words[1]]
        elif words[:1] == ["element"]:
            elements.append(_Element(name=words[1], count=int(words[2]), properties=()))
        elif words[:1] == ["property"]:
            last = elements[-1]
            properties = (*last.properties, tuple(words[1:]))
            elements[-1] = _Element(name=last.name, count=last.count, properties=properties)
        elif words[:1] == ["end_header"]:
            return order, elements, at
    raise ValueError("its header does not end")


def _check_counts(elements: list[_Element], size: int, where: str) -> None:
    for element in elements:
        if not 0 <= element.count <= size:
            raise ValueError(f"it declares {element.count} of {element.name} in {size} bytes")
        if element.name == "face" and element.count > FACES:
            raise too_large(f"has {element.count} faces, of which {FACES} are allowed", where)


def _binary(content: bytes, at: int, order: str, elements: list[_Element]) -> Mesh:
    vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    for element in elements:
        if element.name == "face":
            faces, at = _binary_faces(content, at, order, element)
            continue
        if any(kind[0] == "list" for kind in element.properties):
            raise ValueError(f"{element.name} holds a list, as only faces may")
        layout = np.dtype([(name, order + TYPES[kind]) for kind, name in element.properties])
        rows = np.frombuffer(content, layout, count=element.count, offset=at)
        at += element.count * layout.itemsize
        if element.name == "vertex":
            vertices = np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)
    return Mesh(vertices=vertices, faces=faces)


def _binary_faces(content: bytes, at: int, order: str, element: _Element) -> tuple[Integers, int]:
    if element.count == 0:
        return np.zeros((0, 3), dtype=np.int64), at
    wanted = _corners_of(element)
    # In nearly every file all faces are alike, and so lie in rows like the first.
    alike = _layout_of_first(content, at, order, element)
    if at + element.count * alike.itemsize <= len(content):
        rows = np.frombuffer(content, alike, count=element.count, offset=at)
        counts = [name for name in alike.names or () if name.startswith("count ")]
        if all((rows[name] == rows[name][0]).all() for name in counts):
            corners = rows[wanted].astype(np.int64)
            lengths = np.full(element.count, corners.shape[1])
            return fans(corners.ravel(), lengths), at + element.count * alike.itemsize
    results: list[Integers] = []
    for _ in range(element.count):
        layout = _layout_of_first(content, at, order, element)
        row = np.frombuffer(content, layout, count=1, offset=at)
        results.append(row[wanted][0].astype(np.int64))
        at += layout.itemsize
    return fans(np.concatenate(results), np.array([len(each) for each in results])), at


def _layout_of_first(content: bytes, at: int, order: str, element: _Element) -> np.dtype[np.void]:
    """Return the layout of the face that begins at a byte."""
    fields: list[tuple[object, ...]] = []
    for kind in element.properties:
        if kind[0] != "list":
            fields.append((kind[1], order + TYPES[kind[0]]))
            at += np.dtype(TYPES[kind[0]]).itemsize
            continue
        _, count, item, name = kind
        size, each = np.dtype(order + WHOLE[count]), np.dtype(order + TYPES[item])
        length = int(np.frombuffer(content, size, count=1, offset=at)[0])
        if not 0 <= length * each.itemsize <= len(content) - at:
            raise ValueError(f"a face has {length} of {name}")
        fields += [(f"count {name}", size), (name, each, (length,))]
        at += size.itemsize + length * each.itemsize
    return np.dtype(fields)


def _corners_of(element: _Element) -> str:
    for kind in element.properties:
        if kind[0] == "list" and kind[3] in ("vertex_indices", "vertex_index"):
            if kind[2] not in WHOLE:
                raise ValueError(f"its faces name corners by {kind[2]}, not by whole numbers")
            return kind[3]
    raise ValueError("its faces have no vertex_indices")


def _ascii(content: bytes, at: int, elements: list[_Element]) -> Mesh:
    rows = (result.group().split() for result in LINE.finditer(content + b"\n", at))
    rows = (row for row in rows if row)
    vertices: Array = np.zeros((0, 3))
    polygons: list[Integers] = [np.zeros(0, dtype=np.int64)]
    for element in elements:
        if element.name == "vertex":
            columns = [[kind[-1] for kind in element.properties].index(axis) for axis in "xyz"]
        for number in range(element.count):
            row = next(rows, None)
            if row is None:
                raise ValueError(f"it ends at {element.name} {number} of {element.count}")
            if element.name == "vertex":
                if number == 0:
                    vertices = np.empty((element.count, 3))
                vertices[number] = [float(row[column]) for column in columns]
            elif element.name == "face":
                polygons.append(_ascii_polygon(row, element))
    lengths = np.array([len(each) for each in polygons])
    return Mesh(vertices=vertices, faces=fans(np.concatenate(polygons), lengths))


def _ascii_polygon(row: list[bytes], element: _Element) -> Integers:
    at, wanted = 0, _corners_of(element)
    for kind in element.properties:
        length = int(row[at]) if kind[0] == "list" else 0
        if kind[-1] == wanted:
            return np.array([int(word) for word in row[at + 1 : at + 1 + length]], dtype=np.int64)
        at += 1 + length
    raise ValueError("a face has no corners")
