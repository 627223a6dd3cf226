"""A mesh as a binary STL file."""

from __future__ import annotations

import numpy as np

from morph.print.mesh import Mesh

HEADER = b"binary STL in millimetres"
"""What the file says of itself; a text that began with `solid` would pass for an ASCII file."""

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""One triangle; source: Marshall Burns, Automated Fabrication, 1993, section 6.5."""


def stl(mesh: Mesh) -> bytes:
    """Return the file of a mesh: 84 bytes and 50 for each triangle, mm, the same every time."""
    corners = mesh.corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    record = np.zeros(len(corners), dtype=RECORD)
    record["normal"] = normal / np.where(length > 0, length, 1.0)
    record["corners"] = corners
    count = np.array([len(corners)], dtype="<u4")
    return HEADER.ljust(80, b" ") + count.tobytes() + record.tobytes()
