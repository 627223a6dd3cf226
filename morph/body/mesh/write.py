"""Writing a mesh in the formats that MuJoCo reads."""

from __future__ import annotations

import numpy as np

from morph.body.mesh.solid import Mesh
from morph.body.mesh.stl import HEADER, TRIANGLE


def as_stl(mesh: Mesh) -> bytes:
    """Return a mesh as binary STL, its coordinates rounded to float32."""
    rows = np.zeros(len(mesh.faces), dtype=TRIANGLE)
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"] = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    rows["corners"] = corners
    header = b"binary STL".ljust(HEADER - 4)
    return header + len(rows).to_bytes(4, "little") + rows.tobytes()


def as_obj(mesh: Mesh) -> bytes:
    """Return a mesh as OBJ text, its coordinates exact."""
    corners = (f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
    faces = (f"f {a} {b} {c}\n" for a, b, c in (mesh.faces + 1).tolist())
    return "".join((*corners, *faces)).encode()
