"""The content of a file that an MJCF names, checked before MuJoCo sees it."""

from __future__ import annotations

import struct
from pathlib import Path

from morph.body.mesh import as_stl, mesh_content, read_mesh, thinned
from morph.body.mesh.limits import unreadable
from morph.body.mjcf_bounds import MOST_PIXELS
from morph.body.png import SIGNATURE, why_not_png
from morph.body.shapes import MOST_FACES
from morph.errors import MeshError

STL_HEAD, STL_FACE = 84, 50
"""Bytes of a binary STL before its faces, and of each face."""


def asset_content(tag: str, path: Path) -> tuple[bytes, str, str]:
    """Return a file's content, its ending, and what was done to it, as MuJoCo can read it.

    Args:
        tag: The element that names it: `mesh`, `texture`, `hfield` or `flexcomp`.
        path: The file.

    Raises:
        MeshError: It cannot be used; `code` says why.
    """
    content = mesh_content(path)
    ending = path.suffix.lower()
    if tag == "texture" or (tag == "hfield" and content.startswith(SIGNATURE)):
        _check_picture(content, str(path))
    elif tag == "hfield":
        _check_heights(content, str(path))
    elif tag == "mesh" and ending == ".msh":
        _check_msh(content, str(path))
    elif tag in ("mesh", "flexcomp"):
        return _mesh(content, ending, str(path))
    else:
        raise MeshError(
            f"is named by a <{tag}>, of which morph reads no files",
            where=str(path),
            fix="leave it out",
            code="unsupported",
        )
    return content, path.suffix, ""


def _mesh(content: bytes, ending: str, where: str) -> tuple[bytes, str, str]:
    mesh = read_mesh(content, ending, where)
    if len(mesh.faces) > MOST_FACES:
        return as_stl(thinned(mesh, MOST_FACES)), ".stl", "it was thinned"
    faces = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little")
    if ending == ".obj" or (ending == ".stl" and len(content) == STL_HEAD + STL_FACE * faces):
        return content, ending, ""
    # MuJoCo reads OBJ and binary STL alone.
    return as_stl(mesh), ".stl", ""


def _check_picture(content: bytes, where: str) -> None:
    why = why_not_png(content, MOST_PIXELS)
    if why:
        raise unreadable(why, where, "give a PNG as a drawing program saves it")


def _check_heights(content: bytes, where: str) -> None:
    """Check a height field in MuJoCo's format: rows, columns, then a float of each."""
    if len(content) >= 8:
        rows, columns = struct.unpack("<ii", content[:8])
        if rows > 0 and columns > 0 and len(content) == 8 + 4 * rows * columns:
            return
    raise unreadable("is no height field", where, "give a PNG")


def _check_msh(content: bytes, where: str) -> None:
    """Check a mesh in MuJoCo's old format: four counts, then as many numbers as they say."""
    if len(content) >= 16:
        points, normals, maps, faces = counts = struct.unpack("<iiii", content[:16])
        held = 12 * points + 12 * normals + 8 * maps + 12 * faces
        if min(counts) >= 0 and points > 0 and len(content) == 16 + held:
            return
    raise unreadable("is no mesh of MuJoCo's", where)
