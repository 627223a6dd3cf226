"""Reading the geometry of Wavefront OBJ."""

from __future__ import annotations

import io
import itertools
from array import array

import numpy as np

from morph.body.mesh.limits import FACES, too_large, unreadable
from morph.body.mesh.solid import Mesh

LONGEST = 65536
"""Longest line, bytes; a polygon of ten thousand corners fits."""


def read_obj(content: bytes, where: str) -> Mesh:
    """Return the mesh in an OBJ file: its corners `v` and its polygons `f`.

    A polygon is cut into triangles from its first corner; all else is left out.

    Raises:
        MeshError: A corner or a polygon cannot be read; the line is named.
    """
    for start, most in ((b"\nf ", FACES), (b"\nv ", 3 * FACES)):
        if content.count(start) > most:
            raise too_large(f"has more than {most} lines {start.decode().strip()}", where)
    corners, triangles = array("d"), array("q")
    for number, line in enumerate(io.BytesIO(content), start=1):
        if line[:2] not in (b"v ", b"f ", b"v\t", b"f\t"):
            continue
        try:
            if len(line) > LONGEST:
                raise ValueError
            words = line.split()
            if words[0] == b"v":
                x, y, z = words[1:4]
                corners.extend((float(x), float(y), float(z)))
            else:
                _fan(words[1:], len(corners) // 3, triangles)
        except (ValueError, OverflowError) as error:
            raise unreadable(f"cannot be read: {line[:60]!r}", f"{where}:{number}") from error
        if len(triangles) > 3 * FACES:
            raise too_large(f"has more than the {FACES} faces allowed", where)
    return Mesh(
        vertices=np.frombuffer(corners, dtype=np.float64).reshape(-1, 3),
        faces=np.frombuffer(triangles, dtype=np.int64).reshape(-1, 3),
    )


def _fan(words: list[bytes], known: int, triangles: array[int]) -> None:
    # A corner is `index`, `index/texture` or `index/texture/normal`, from 1;
    # a negative one counts back from the last corner read.
    indices = [int(word.split(b"/", 1)[0]) for word in words]
    if len(indices) < 3 or 0 in indices:
        raise ValueError
    first, *rest = [index - 1 if index > 0 else known + index for index in indices]
    for second, third in itertools.pairwise(rest):
        triangles.extend((first, second, third))
