"""Reading STL, binary and ASCII."""

from __future__ import annotations

import re

import numpy as np

from morph.arrays import Array
from morph.body.mesh.limits import FACES, too_large, unreadable
from morph.body.mesh.solid import Mesh

HEADER = 84
"""Bytes before the triangles: 80 of any text, 4 for their number."""

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""One triangle of a binary file, 50 bytes."""

VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read_stl(content: bytes, where: str) -> Mesh:
    """Return the mesh in an STL file; three corners a face, none shared.

    A file is binary if its length fits the number of triangles that it
    declares, even where it begins with `solid` as ASCII files do.

    Raises:
        MeshError: It is neither kind of STL, or is too large.
    """
    declared = int.from_bytes(content[80:HEADER], "little") if len(content) >= HEADER else -1
    if declared >= 0 and HEADER + TRIANGLE.itemsize * declared == len(content):
        corners = np.frombuffer(content, TRIANGLE, count=declared, offset=HEADER)["corners"]
        return _soup(corners.reshape(-1, 3).astype(np.float64))
    if content.lstrip()[:5].lower() == b"solid" and b"\0" not in content[:1024]:
        return _soup(_ascii(content, where))
    if declared < 0:
        raise unreadable(f"has {len(content)} bytes, and binary STL has at least {HEADER}", where)
    raise unreadable(
        f"declares {declared} triangles, {HEADER + TRIANGLE.itemsize * declared} bytes, "
        f"and has {len(content)} bytes",
        where,
    )


def _soup(corners: Array) -> Mesh:
    return Mesh(vertices=corners, faces=np.arange(len(corners), dtype=np.int64).reshape(-1, 3))


def _ascii(content: bytes, where: str) -> Array:
    count = len(re.findall(rb"endfacet", content, re.IGNORECASE))
    if count > FACES:
        raise too_large(f"has {count} faces, of which {FACES} are allowed", where)
    numbers = np.empty((3 * count, 3))
    row = 0
    try:
        for result in VERTEX.finditer(content):
            numbers[row] = [float(text) for text in result.groups()]
            row += 1
    except (ValueError, IndexError) as error:
        raise unreadable(
            f"vertex {row} cannot be read as three numbers of a face", where
        ) from error
    if row != 3 * count:
        raise unreadable(f"{count} facets have {row} vertices, not {3 * count}", where)
    return numbers
