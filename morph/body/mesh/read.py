"""Reading a mesh from a file's bytes, whatever they hold."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path

import numpy as np

from morph.body.mesh.collada import read_collada
from morph.body.mesh.limits import FACES, FARTHEST, LARGEST, empty, too_large, unreadable
from morph.body.mesh.obj import read_obj
from morph.body.mesh.ply import read_ply
from morph.body.mesh.solid import Mesh
from morph.body.mesh.step import read_step
from morph.body.mesh.stl import read_stl
from morph.body.mesh.threemf import read_3mf
from morph.errors import MeshError
from morph.regular_file import read_regular

READERS: dict[str, Callable[[bytes, str], Mesh]] = {
    "stl": read_stl,
    "obj": read_obj,
    "ply": read_ply,
    "3mf": read_3mf,
    "dae": read_collada,
    "step": read_step,
    "stp": read_step,
}
"""The reader for each ending."""

STUB = b"version https://git-lfs"
"""How the pointer begins that Git LFS leaves where a file should be."""


def mesh_content(path: Path) -> bytes:
    """Return the bytes of a mesh file, or of another file that a description names.

    Raises:
        MeshError: It has more than 64 MiB, is no regular file, or cannot be read.
    """
    try:
        return read_regular(path, LARGEST)
    except (OSError, ValueError) as error:
        if getattr(error, "errno", None) == errno.EFBIG:
            raise too_large(
                f"is too large: {getattr(error, 'strerror', error)}", str(path)
            ) from error
        raise unreadable(
            f"cannot be read: {getattr(error, 'strerror', None) or error}",
            str(path),
            "put the plain file there, and allow reading it",
        ) from error


def read_mesh(content: bytes, ending: str, where: str) -> Mesh:
    """Return the mesh that a file's bytes hold, all its parts as one.

    Units are those of the file, except that 3MF, COLLADA and STEP state theirs
    and are given in metres. Nothing but the bytes is read, so textures and
    materials are left out.

    Args:
        content: The file's bytes, at most 64 MiB.
        ending: The file's ending, with its dot or without, in any case.
        where: The file's name, for errors.

    Raises:
        MeshError: `code` says why: `mesh-lfs-stub`, `mesh-empty`,
            `mesh-too-large`, or `mesh-unreadable` for all else.
    """
    reader = READERS.get(ending.lower().lstrip("."))
    if reader is None:
        raise unreadable(
            f"meshes that end in {ending!r} cannot be read",
            where,
            f"give a file that ends in {', '.join(READERS)}",
        )
    if content.startswith(STUB):
        raise MeshError(
            "is the pointer that Git LFS left in place of the mesh",
            where=where,
            fix="run git lfs pull where the description came from",
            code="mesh-lfs-stub",
        )
    if len(content) > LARGEST:
        raise too_large(f"has {len(content)} bytes, of which {LARGEST} are allowed", where)
    if not content.strip():
        raise empty("is empty", where)
    # Numbers that overflow under a transform are found below, as corners that are nowhere.
    with np.errstate(over="ignore", invalid="ignore"):
        mesh = reader(content, where)
    _check(mesh, where)
    return mesh


def _check(mesh: Mesh, where: str) -> None:
    if len(mesh.faces) == 0:
        raise empty("has no faces", where)
    if len(mesh.faces) > FACES:
        raise too_large(f"has {len(mesh.faces)} faces, of which {FACES} are allowed", where)
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        bad = mesh.faces[(mesh.faces < 0) | (mesh.faces >= len(mesh.vertices))][0]
        raise unreadable(
            f"a face names corner {bad}, and there are {len(mesh.vertices)}, from 0", where
        )
    # A comparison with NaN is false, so this also finds what is not a number.
    near = np.abs(mesh.vertices) <= FARTHEST
    if not near.all():
        row = int(np.flatnonzero(~near.all(axis=1))[0])
        raise unreadable(
            f"corner {row} is at {mesh.vertices[row].tolist()}, not at numbers within {FARTHEST:g}",
            where,
        )
