"""Maps in files: numbers by name in an npz, hostile until checked."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError
from morph.alignment.maps.body_map import BodyMap
from morph.alignment.maps.maps import kind_of

MOST_BYTES = 16_000_000
"""Most bytes of a map's numbers, unpacked."""

MOST_NUMBERS = 2000
"""Most arrays in one file."""

KIND = "kind"
"""Under which name the file says what sort of map it holds."""


def write(path: Path, body_map: BodyMap) -> None:
    """Write a map whole or not at all.

    Args:
        path: Ends in .npz.
        body_map: The map.
    """
    numbers: dict[str, Any] = {KIND: np.array(body_map.kind), **body_map.weights()}
    part = path.with_name(f".{path.name}.part")
    try:
        with part.open("wb") as file:
            np.savez(file, allow_pickle=False, **numbers)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def read(path: Path) -> BodyMap:
    """Return the map of a file.

    Raises:
        MapError: It is no such file, is too large, holds objects, or its numbers make no map.
    """
    try:
        _measured(path)
        # Objects would be pickles, and pickles run what they are told to.
        with np.load(path, allow_pickle=False) as file:
            results = {name: file[name] for name in file.files}
    # numpy and zipfile raise a dozen unrelated errors on damaged bytes.
    except Exception as e:
        raise MapError(
            f"it cannot be read: {e}",
            where=f"map {path}",
            fix="give an .npz that was written as a map, without objects in it",
        ) from e
    kind = results.pop(KIND, np.array(0.0))
    plain = [kind, *results.values()]
    if not all(isinstance(value, np.ndarray) for value in plain):
        raise MapError(
            "it holds what is no array",
            where=f"map {path}",
            fix="give an .npz that was written as a map, without objects in it",
        )
    if kind.ndim or kind.dtype.kind != "U":
        raise MapError(
            "it does not say what kind of map it is",
            where=f"map {path}",
            fix=f"give one word under the name {KIND!r}, such as affine",
        )
    return kind_of(str(kind)).of({name: _numbers(path, name, results[name]) for name in results})


def _measured(path: Path) -> None:
    """Check what an archive says that it holds before any of it is unpacked."""
    # A pipe would be waited for, and of a device one would read for ever.
    if path.exists() and not path.is_file():
        raise ValueError("it is no plain file")
    if path.stat().st_size > 2 * MOST_BYTES:
        raise ValueError(f"it has {path.stat().st_size} bytes")
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    size = sum(member.file_size for member in members)
    if len(members) > MOST_NUMBERS or size > MOST_BYTES:
        raise ValueError(
            f"{len(members)} arrays of {size} bytes, where {MOST_NUMBERS} of {MOST_BYTES} may be"
        )


def _numbers(path: Path, name: str, value: Array) -> Array:
    if value.dtype.kind not in "fiub" or not np.isfinite(value).all():
        raise MapError(
            f"{name} holds {value.dtype} that are not all finite numbers",
            where=f"map {path}",
            fix="write the map again with finite numbers",
        )
    return np.asarray(value, dtype=float)
