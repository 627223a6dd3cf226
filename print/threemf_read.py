"""A 3MF file read back, as strictly as lib3mf can."""

from __future__ import annotations

import errno
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.errors import PlateError
from morph.print.mesh import Mesh

LARGEST = 1 << 28
"""Bytes of the largest file that is read; a plate of a million triangles has some ten million."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Read:
    """What stands in a 3MF file."""

    unit: str
    """Its unit of length, as lib3mf spells it: `MilliMeter`."""
    meshes: Mapping[str, Mesh]
    """Each object by its name, in the unit above."""
    numbers: Mapping[str, str]
    """Part number of each object."""
    items: tuple[tuple[str, Array], ...]
    """What is built: the object's name and its pose, shape (4, 4)."""
    metadata: Mapping[str, str]
    """What it says of itself, without namespaces."""


def read_3mf(source: Path | bytes) -> Read:
    """Return what a 3MF file holds.

    Raises:
        PlateError: It cannot be read, or lib3mf warns of anything in strict mode.
    """
    import lib3mf

    where = str(source) if isinstance(source, Path) else "3MF in memory"
    with told(where):
        model = lib3mf.get_wrapper().CreateModel()
        reader = model.QueryReader("3mf")
        reader.SetStrictModeActive(True)
        reader.ReadFromBuffer(_content(source))
        warnings = [reader.GetWarning(at)[1] for at in range(reader.GetWarningCount())]
        if warnings:
            raise PlateError(
                f"lib3mf warns: {'; '.join(warnings)}",
                where=where,
                fix="write it anew; it is not valid in the strict reading",
            )
        objects = list(_each(model.GetMeshObjects(), "GetCurrentMeshObject"))
        return Read(
            unit=model.GetUnit().name,
            meshes={each.GetName(): _mesh(each) for each in objects},
            numbers={each.GetName(): each.GetPartNumber() for each in objects},
            items=tuple(
                (item.GetObjectResource().GetName(), _pose(item.GetObjectTransform()))
                for item in _each(model.GetBuildItems(), "GetCurrent")
            ),
            metadata=_metadata(model.GetMetaDataGroup()),
        )


def _content(source: Path | bytes) -> bytes:
    """Return a file's bytes; lib3mf's own messages about files say too little."""
    if isinstance(source, bytes):
        return source
    try:
        # A pipe would be waited for, and of a device one would read for ever.
        if source.exists() and not source.is_file():
            raise OSError(errno.EINVAL, "it is no plain file")
        size = source.stat().st_size
        content = source.read_bytes() if 0 < size <= LARGEST else b""
    except OSError as error:
        raise PlateError(
            f"cannot read: {error.strerror or error}",
            where=str(source),
            fix="name a 3MF file that is there and can be read",
        ) from error
    if not content:
        raise PlateError(
            f"the file has {size} bytes, and 1 to {LARGEST} are read",
            where=str(source),
            fix="write it anew",
        )
    return content


def _each(iterator: Any, current: str) -> Iterator[Any]:
    """Yield what an iterator of lib3mf walks over."""
    while iterator.MoveNext():
        yield getattr(iterator, current)()


def _mesh(made: Any) -> Mesh:
    """Return an object's corners and triangles."""
    corners, faces = made.GetVertices(), made.GetTriangleIndices()
    # Each is a list of structures of three numbers of four bytes.
    return Mesh(
        vertices=np.array([tuple(each.Coordinates) for each in corners], dtype=np.float64),
        faces=np.array([tuple(each.Indices) for each in faces], dtype=np.int64),
    )


def _pose(transform: Any) -> Array:
    """Return a transform of four columns as a matrix of four rows."""
    pose = np.eye(4)
    pose[:3] = np.array([list(column) for column in transform.Fields]).T
    return pose


def _metadata(group: Any) -> dict[str, str]:
    """Return all names and values of a group."""
    entries = [group.GetMetaData(at) for at in range(group.GetMetaDataCount())]
    return {entry.GetName(): entry.GetValue() for entry in entries}


@contextmanager
def told(where: str) -> Iterator[None]:
    """Tell what lib3mf refuses as ours."""
    import lib3mf

    try:
        yield
    except lib3mf.ELib3MFException as error:
        raise PlateError(
            f"lib3mf refuses it: {error}",
            where=where,
            fix="see that the file is a whole 3MF file, and that each part is a closed solid",
        ) from error
