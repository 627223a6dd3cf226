"""Reading a package that `morph print` wrote; it may come from a stranger."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from morph.body.mesh import mesh_content, read_mesh
from morph.body.table import Place, read_table
from morph.errors import MakeError, MeshError, RobotError
from morph.fabrication.content import Package
from morph.fabrication.packed import FILE, SCHEMA, Packed, PackedPart
from morph.fabrication.unpack import unpacked
from morph.print.mesh import Mesh
from morph.regular_file import open_regular, read_regular

MOST_BYTES = 8 * 2**20
"""Largest `package.json`; that of the humanoid has about one million bytes."""

MOST_PARTS = 5000
"""Most parts whose shapes are read."""


def read_package(folder: str | Path) -> Package:
    """Return the package in a folder, with the shapes of its parts.

    Raises:
        MakeError: There is none, or a file in it is damaged, too large or elsewhere.
    """
    place = Path(folder)
    packed = read_packed(place / FILE)
    if len(packed.parts) + len(packed.gauges) > MOST_PARTS:
        raise _bad(place / FILE, f"it has more than {MOST_PARTS} parts")
    return unpacked(packed, place, lambda part: _mesh(place, part))


def is_package(folder: Path) -> bool:
    """Return whether a folder holds a package of ours, however damaged."""
    try:
        with open_regular(folder / FILE) as file:
            return SCHEMA.encode() in file.read(4096)
    except OSError:
        return False


def read_packed(path: Path) -> Packed:
    """Return what a `package.json` holds, every field of it known.

    Raises:
        MakeError: There is none, or it is damaged or too large.
    """
    try:
        document = json.loads(read_regular(path, MOST_BYTES), parse_constant=_no_number)
    except FileNotFoundError as error:
        raise MakeError(
            "there is no package",
            where=str(path),
            fix="name a folder that `morph print` wrote",
        ) from error
    except OSError as error:
        raise _bad(path, f"it cannot be read: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise _bad(path, f"it is no JSON: {error}") from error
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise _bad(path, f"its schema is not {SCHEMA}")
    try:
        return read_table(Packed, _said(document), Place(file=str(path), text=""))
    except RobotError as error:
        raise _bad(path, error.what) from error


def _said(value: Any) -> Any:
    """Return what is said without what is null: a table says nothing of it."""
    if isinstance(value, dict):
        return {key: _said(each) for key, each in value.items() if each is not None}
    if isinstance(value, list):
        return [_said(each) for each in value]
    return value


def _no_number(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _mesh(folder: Path, part: PackedPart) -> Mesh | None:
    if not part.file:
        return None
    path = folder / part.file
    try:
        if not path.resolve().is_relative_to(folder.resolve()):
            raise _bad(folder / FILE, f"the file {part.file!r} is not in the package")
        result = read_mesh(mesh_content(path), ".stl", str(path)).merged
    except MeshError as error:
        raise MakeError(error.what, where=error.where, fix=error.fix) from error
    except OSError as error:
        raise _bad(path, f"it cannot be read: {error.strerror or error}") from error
    turned = Mesh(vertices=result.vertices, faces=result.faces)
    if part.printed is None:
        return turned
    # It lies as it is printed; its own frame is the turn undone.
    back = np.eye(4)
    back[:3, :3] = np.array(part.printed.turn, dtype=np.float64).reshape(3, 3).T
    return turned.moved(back)


def _bad(path: Path, what: str) -> MakeError:
    return MakeError(what, where=str(path), fix="make the package anew with `morph print`")
