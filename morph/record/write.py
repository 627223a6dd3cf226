"""Writing a recording under its canonical names."""

from __future__ import annotations

import gzip
import io
import itertools
import re
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import OutputError
from morph.files import write_whole
from morph.record.canonical import CLOCK
from morph.record.recording import Recording

ENDINGS = (".csv", ".csv.gz", ".npz", ".parquet")
"""The endings of the files that can be written."""


def write(recording: Recording, path: Path) -> Path:
    """Write a recording's channels; the file's ending says how.

    `time` is the clock of the first measured channel; one with another clock stands beside it,
    `<channel>.time`. In CSV and Parquet the cells below the shorter ones are empty.

    Returns:
        The path written.

    Raises:
        OutputError: The ending is unknown, or the file cannot be written.
    """
    name, columns = path.name.lower(), _columns(recording)
    if name.endswith(".npz"):
        return write_whole(path, _npz(columns))
    if name.endswith(".parquet"):
        return write_whole(path, _parquet(columns))
    if name.endswith(".csv.gz"):
        # Without a time stamp the same recording gives the same bytes.
        return write_whole(path, gzip.compress(_csv(columns), mtime=0))
    if name.endswith(".csv"):
        return write_whole(path, _csv(columns))
    raise OutputError(
        f"a recording cannot be written as {path.name!r}",
        where=str(path),
        fix=f"end the name in {', '.join(ENDINGS)}",
    )


def _columns(recording: Recording) -> dict[str, Array]:
    """Return `time`, every channel and the clocks that differ, shape (samples of its own,) each."""
    channels = recording.channels
    first = next((one for one in channels.values() if not one.hold), next(iter(channels.values())))
    columns = {"time": first.time}
    for name, channel in channels.items():
        if not np.array_equal(channel.time, first.time):
            columns[f"{name}{CLOCK}"] = channel.time
        columns[name] = channel.value
    return columns


def _csv(columns: dict[str, Array]) -> bytes:
    # Python's shortest text of a float reads back as the same float.
    cells = [map(repr, column.tolist()) for column in columns.values()]
    names = [f'"{name}"' if re.search("[,;\t]", name) else name for name in columns]
    lines = [",".join(names), *map(",".join, itertools.zip_longest(*cells, fillvalue=""))]
    return ("\n".join(lines) + "\n").encode()


def _parquet(columns: dict[str, Array]) -> bytes:
    import pyarrow
    from pyarrow import parquet

    rows, sink = max(map(len, columns.values())), io.BytesIO()
    filled = {
        name: pyarrow.concat_arrays(
            [pyarrow.array(column), pyarrow.nulls(rows - len(column), pyarrow.float64())]
        )
        for name, column in columns.items()
    }
    parquet.write_table(pyarrow.table(filled), sink, compression="zstd")
    return sink.getvalue()


def _npz(columns: dict[str, Array]) -> bytes:
    sink = io.BytesIO()
    np.savez_compressed(sink, allow_pickle=False, **columns)
    return sink.getvalue()
