"""Reading a file by its ending."""

from __future__ import annotations

from pathlib import Path

from morph.errors import RecordingError
from morph.record.nearest import nearest
from morph.record.read.csv import read_csv
from morph.record.read.npz import read_npz
from morph.record.read.parquet import read_parquet
from morph.record.read.table import Table

ENDINGS = (".csv", ".csv.gz", ".npz", ".parquet")
"""The endings of the files that can be read."""


def readable(path: Path) -> bool:
    """Return whether a file's ending is one of `ENDINGS`."""
    return path.name.lower().endswith(ENDINGS)


def read(path: Path, key: str | None = None) -> Table:
    """Return a file's columns.

    Args:
        path: The file; its ending says how it is read.
        key: For an NPZ file with one array per episode, the array.

    Raises:
        RecordingError: The ending is unknown, the file cannot be read, or a key
            is given for a file that has none.
    """
    name = path.name.lower()
    if not readable(path):
        raise RecordingError(
            f"the ending of {path.name!r} is unknown; files end in {', '.join(ENDINGS)}",
            where=str(path),
            fix=f"the nearest are {nearest(path.suffix, ENDINGS)}; convert the file",
        )
    if name.endswith(".npz"):
        return read_npz(path, key)
    if key is not None:
        raise RecordingError(
            f"the key {key!r} is given for a file without keys",
            where=str(path),
            fix="remove the key; only NPZ files hold one array per episode",
        )
    return read_parquet(path) if name.endswith(".parquet") else read_csv(path)
