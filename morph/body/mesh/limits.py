"""What a mesh file may hold, and the errors for one that cannot be used."""

from __future__ import annotations

from morph.errors import MeshError

LARGEST = 64 * 1024 * 1024
"""Greatest size of a file, and of what unpacks from it, bytes."""

FACES = 2_000_000
"""Greatest number of faces."""

FARTHEST = 1e9
"""Greatest coordinate; a robot of that size in micrometres is a kilometre long."""

EXPORT = "export the mesh again, as binary STL or OBJ"


def unreadable(what: str, where: str, fix: str = EXPORT) -> MeshError:
    """Return the error for bytes that are not what their ending says."""
    return MeshError(what, where=where, fix=fix, code="mesh-unreadable")


def empty(what: str, where: str) -> MeshError:
    """Return the error for a file with no faces."""
    return MeshError(what, where=where, fix=EXPORT, code="mesh-empty")


def too_large(what: str, where: str) -> MeshError:
    """Return the error for a file above the limits."""
    fix = "reduce the mesh to fewer faces, as a simulation needs no more"
    return MeshError(what, where=where, fix=fix, code="mesh-too-large")
