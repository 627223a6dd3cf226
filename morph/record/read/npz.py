"""Reading NPZ files: one array per column, or one array per episode."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.nearest import nearest
from morph.npz import load_npz
from morph.record.limits import most_unpacked, too_much
from morph.record.read.file import opened
from morph.record.read.table import Table


def read_npz(path: Path, key: str | None = None) -> Table:
    """Return the arrays of an NPZ file as columns.

    Args:
        path: The file; nothing in it is unpickled.
        key: The array, of shape (rows, columns), that holds one episode; its
            columns have numbers only. None: each array is a column, and one of
            shape (rows, elements) is a column whose cells hold lists.

    Raises:
        RecordingError: The file is missing, empty or damaged, or has no such array.
    """
    arrays = _arrays(path)
    if key is None:
        return Table(path=path, names=tuple(arrays), columns=tuple(arrays.values()))
    if key not in arrays:
        raise RecordingError(
            f"there is no array {key!r}; the file has {len(arrays)} arrays",
            where=str(path),
            fix=f"name an array that is there; the nearest are {nearest(key, arrays)}",
        )
    episode = arrays[key]
    columns = tuple(episode.T) if episode.ndim == 2 else (episode,)
    return Table(path=path, names=(), columns=columns)


def _arrays(path: Path) -> dict[str, Array]:
    with opened(path) as file:
        most = most_unpacked(os.fstat(file.fileno()).st_size)
        try:
            loaded = load_npz(file, most)
        except OSError as error:
            raise too_much(error.strerror or str(error), str(path)) from error
        except ValueError as error:
            raise RecordingError(
                f"the file is truncated, damaged or not an NPZ of plain numbers: {error}",
                where=str(path),
                fix="copy the file again, or save it with numpy.savez and without objects",
            ) from error
    kept: dict[str, Array] = {}
    with np.errstate(over="ignore"):
        for name in tuple(loaded):
            # Taken out, so that what is converted is not held twice.
            array = loaded.pop(name)
            if array.dtype.kind in "fiub" and array.ndim in (1, 2):
                kept[name] = array.astype(np.float64, copy=False)
    if not kept or not any(array.size for array in kept.values()):
        raise RecordingError(
            "the file holds no array of numbers of one or two dimensions",
            where=str(path),
            fix="save the samples as arrays of shape (rows,) or (rows, columns)",
        )
    return kept
