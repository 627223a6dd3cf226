"""Convex pieces of a mesh, for contacts that follow its shape; computed once and kept."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.body.mesh import Mesh
from morph.errors import MeshError, MorphError
from morph.files import sha256, write_whole
from morph.npz import load_npz

MOST_STORED = 2**28
"""Most bytes of the pieces of one mesh; a hundred pieces of a thousand corners have 8 MB."""

EDITION = "1"
"""Part of every key of the cache; raised when the same settings come to mean other pieces."""


@dataclass(frozen=True, kw_only=True)
class Cutting:
    """How a mesh is cut."""

    threshold: float = 0.05
    """Greatest concavity left in a piece, as a part of the mesh's size, 0.01 to 1."""
    most: int = 16
    """Most pieces."""
    corners: int = 64
    """Most corners of a piece; a contact costs time with each."""
    seed: int = 0
    """Seed of the search for cuts."""


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """The convex pieces of a mesh, and how much more room than it they take."""

    meshes: tuple[Mesh, ...]
    """Convex, closed, wound outward, in the mesh's own frame and units."""
    hull_ratio: float
    """Volume of the mesh's one convex hull, by that of the mesh: 1 if it is convex."""
    pieces_ratio: float
    """Volume of all pieces together, by that of the mesh."""


def convex_pieces(mesh: Mesh, cutting: Cutting | None = None) -> Pieces:
    """Return the convex pieces of a mesh, from the cache if they are in it.

    Takes seconds to minutes the first time, so nothing calls it unasked. The
    ratios mean what they say for a mesh that is watertight.

    Source: Wei, Liu, Ling and Su 2022, "Approximate convex decomposition for 3D
    meshes with collision-aware concavity and tree search", ACM TOG 41(4).

    Raises:
        MeshError: The mesh encloses nothing, or cannot be cut.
    """
    cutting = cutting or Cutting()
    if mesh.hollow:
        raise MeshError(
            f"its {len(mesh.faces)} faces enclose nothing that could be cut into pieces",
            where="morph.body.pieces.convex_pieces",
            fix="give a mesh that encloses a volume",
            code="mesh-empty",
        )
    # Hulls, so that a piece is convex to rounding and wound outward.
    results = tuple(piece.hull for piece in _cut_once(mesh.merged, cutting))
    volume = abs(mesh.volume)
    return Pieces(
        meshes=results,
        hull_ratio=mesh.hull.volume / volume,
        pieces_ratio=sum(piece.volume for piece in results) / volume,
    )


def cache_folder() -> Path:
    """Return the folder of what can be computed again; it need not exist.

    `MORPH_CACHE` names it; otherwise it is `morph` in the platform's cache folder.
    """
    named = os.environ.get("MORPH_CACHE")
    if named:
        return Path(named)
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return (Path(local) if local else Path.home() / "AppData" / "Local") / "morph" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "morph"
    named = os.environ.get("XDG_CACHE_HOME")
    return (Path(named) if named else Path.home() / ".cache") / "morph"


def _cut_once(mesh: Mesh, cutting: Cutting) -> tuple[Mesh, ...]:
    key = sha256(EDITION, repr(asdict(cutting)), mesh.vertices.tobytes(), mesh.faces.tobytes())
    path = cache_folder() / "pieces" / f"{key}.npz"
    result = _stored(path)
    if result is None:
        result = _cut(mesh, cutting)
        # A cache that cannot be written to costs time, not the result.
        with contextlib.suppress(MorphError):
            write_whole(path, _packed(result))
    return result


def _cut(mesh: Mesh, cutting: Cutting) -> tuple[Mesh, ...]:
    # Loads a library of 20 MB that only this needs.
    import coacd

    outward = mesh.faces if mesh.volume > 0 else mesh.faces[:, ::-1]
    coacd.set_log_level("off")
    try:
        parts = coacd.run_coacd(
            coacd.Mesh(mesh.vertices, outward.astype(np.int32)),
            threshold=cutting.threshold,
            max_convex_hull=cutting.most,
            decimate=True,
            max_ch_vertex=cutting.corners,
            seed=cutting.seed,
        )
    except (RuntimeError, ValueError) as error:
        raise _uncut(f"CoACD cannot cut it: {error}") from error
    pieces = tuple(
        Mesh(vertices=np.asarray(vertices, np.float64), faces=np.asarray(faces, np.int64))
        for vertices, faces in parts
    )
    solid = tuple(piece for piece in pieces if len(piece.faces) and not piece.hollow)
    if not solid:
        raise _uncut("CoACD found no piece in it")
    return solid


def _uncut(what: str) -> MeshError:
    return MeshError(
        what,
        where="morph.body.pieces.convex_pieces",
        fix="close the mesh, or take its convex hull for contacts",
        code="mesh-unreadable",
    )


def _packed(pieces: tuple[Mesh, ...]) -> bytes:
    sink = io.BytesIO()
    arrays: dict[str, Any] = {}
    for at, piece in enumerate(pieces):
        arrays[f"vertices_{at}"], arrays[f"faces_{at}"] = piece.vertices, piece.faces
    np.savez(sink, allow_pickle=False, **arrays)
    return sink.getvalue()


def _stored(path: Path) -> tuple[Mesh, ...] | None:
    """Return the pieces in a file of the cache, or None if it is missing or damaged."""
    try:
        stored = load_npz(path, MOST_STORED)
        pieces = tuple(
            Mesh(vertices=stored[f"vertices_{at}"], faces=stored[f"faces_{at}"])
            for at in range(len(stored) // 2)
        )
    except (OSError, ValueError, KeyError):
        return None
    return pieces if pieces and all(_sound(piece) for piece in pieces) else None


def _sound(piece: Mesh) -> bool:
    corners, faces = piece.vertices, piece.faces
    return bool(
        corners.dtype == np.float64
        and faces.dtype == np.int64
        and corners.ndim == faces.ndim == 2
        and corners.shape[1] == faces.shape[1] == 3
        and faces.size
        and np.isfinite(corners).all()
        and 0 <= faces.min() <= faces.max() < len(corners)
    )
