"""Reading a file, or a bag, by its ending."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from morph.errors import RecordingError
from morph.nearest import nearest
from morph.record.read.hdf5 import read_episodes, read_hdf5
from morph.record.read.npz import read_npz
from morph.record.read.parquet import read_parquet
from morph.record.read.rosbag import ENDINGS as BAG_ENDINGS
from morph.record.read.rosbag import is_bag, read_rosbag
from morph.record.read.table import Table

HDF5_ENDINGS = (".h5", ".hdf5")
"""The endings of HDF5 files."""
ENDINGS = (".csv", ".csv.gz", ".npz", ".parquet", *HDF5_ENDINGS, *BAG_ENDINGS)
"""The endings of the files that can be read."""


def readable(path: Path) -> bool:
    """Return whether a path is a bag's folder, or a file whose ending is one of `ENDINGS`."""
    return is_bag(path) or path.name.lower().endswith(ENDINGS)


def read(
    path: Path, key: str | None = None, wanted: Collection[str] | None = None
) -> tuple[Table, ...]:
    """Return a file's columns; those of a bag in one table per clock, all others in one.

    Args:
        path: The file, or a bag's folder; the ending says how it is read.
        key: For an NPZ or HDF5 file that holds several episodes, the array or the
            group of one.
        wanted: The columns that are needed. Bags and HDF5 files are read no
            further; None reads all that can be read.

    Raises:
        RecordingError: The ending is unknown, the file cannot be read, or a key
            is given for a file that has none.
    """
    name = path.name.lower()
    if not readable(path):
        if not path.exists():
            raise RecordingError(
                "there is no such file or folder",
                where=str(path),
                fix="see that the path is right, from the folder in which the command runs",
            )
        raise RecordingError(
            f"the ending of {path.name!r} is unknown; files end in {', '.join(ENDINGS)}",
            where=str(path),
            fix=f"the nearest are {nearest(path.suffix, ENDINGS)}; convert the file",
        )
    if name.endswith(".npz"):
        return (read_npz(path, key),)
    if name.endswith(HDF5_ENDINGS):
        return (read_hdf5(path, key, wanted),)
    if key is not None:
        raise RecordingError(
            f"the key {key!r} is given for a file without keys",
            where=str(path),
            fix="remove the key; only NPZ and HDF5 files hold several episodes",
        )
    if is_bag(path):
        return read_rosbag(path, wanted)
    if name.endswith(".parquet"):
        return (read_parquet(path),)
    from morph.record.read.csv import read_csv

    return (read_csv(path),)


def read_all(path: Path) -> tuple[tuple[str | None, tuple[Table, ...]], ...]:
    """Return the columns of each episode in a file that no binding describes, with its key.

    Only an HDF5 file has several; the key of any other is None.

    Raises:
        RecordingError: The ending is unknown, or the file cannot be read.
    """
    if path.name.lower().endswith(HDF5_ENDINGS):
        return tuple((key, (table,)) for key, table in read_episodes(path))
    return ((None, read(path)),)
