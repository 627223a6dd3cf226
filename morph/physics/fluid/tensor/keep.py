"""Tensors that were computed once, kept by the content of their mesh."""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from morph.body.mesh import Mesh
from morph.body.pieces import cache_folder
from morph.errors import MorphError
from morph.files import sha256, write_whole
from morph.physics.fluid.tensor.tensor import Tensor

EDITION = "1"
"""Part of every key; raised when the same mesh and settings come to give another tensor."""

FIELDS = ("matrix", "volume", "centre", "point", "error", "panels")


def kept(mesh: Mesh, settings: str, compute: Callable[[], Tensor]) -> Tensor:
    """Return the tensor of a mesh from the cache, computed first if it is not there.

    Args:
        mesh: The mesh; its bytes are the key.
        settings: Whatever else the tensor depends on.
        compute: Computes it; what it raises goes through.
    """
    key = sha256(EDITION, settings, mesh.vertices.tobytes(), mesh.faces.tobytes())
    path = cache_folder() / "tensors" / f"{key}.npz"
    found = _stored(path)
    if found is None:
        found = compute()
        # A cache that cannot be written to costs time, not the result.
        with contextlib.suppress(MorphError):
            write_whole(path, _packed(found))
    return found


def _packed(tensor: Tensor) -> bytes:
    sink = io.BytesIO()
    values = {name: np.asarray(getattr(tensor, name)) for name in FIELDS}
    np.savez(sink, allow_pickle=False, **values)
    return sink.getvalue()


def _stored(path: Path) -> Tensor | None:
    """Return the tensor in a file of the cache, or None if it is missing or damaged."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as stored:
            found = {name: stored[name] for name in FIELDS}
        return Tensor(
            matrix=found["matrix"].astype(np.float64).reshape(6, 6),
            volume=float(found["volume"]),
            centre=found["centre"].astype(np.float64).reshape(3),
            point=found["point"].astype(np.float64).reshape(3),
            error=float(found["error"]),
            panels=int(found["panels"]),
        )
    except (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile, MorphError):
        return None
