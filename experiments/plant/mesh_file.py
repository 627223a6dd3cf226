"""Mesh files rewritten: in other units, elsewhere, or inside out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

REWRITABLE = (".stl", ".obj")
"""Kinds that trimesh writes as it reads them."""


def rewrite(file: Path, change: Callable[[Any], None]) -> None:
    """Change a mesh file in its place: the corners and faces as they stand, none made one."""
    import trimesh

    read: Any = trimesh.load(file, force="mesh", process=False)
    # Without its materials, so that no second file is written beside it.
    bare = trimesh.Trimesh(vertices=read.vertices, faces=read.faces, process=False)
    change(bare)
    bare.export(file, file_type=file.suffix[1:].lower())
