"""Writing a recording under its canonical names."""

from __future__ import annotations

import gzip
import io
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

    NPZ keeps every channel on its own clock. CSV and Parquet have one clock, that
    of the first measured channel: what has another is held or interpolated there.

    Returns:
        The path written.

    Raises:
        OutputError: The ending is unknown, or the file cannot be written.
    """
    name = path.name.lower()
    if name.endswith(".npz"):
        return write_whole(path, _npz(recording))
    if name.endswith(".parquet"):
        return write_whole(path, _parquet(_columns(recording)))
    if name.endswith(".csv.gz"):
        # Without a time stamp the same recording gives the same bytes.
        return write_whole(path, gzip.compress(_csv(_columns(recording)), mtime=0))
    if name.endswith(".csv"):
        return write_whole(path, _csv(_columns(recording)))
    raise OutputError(
        f"a recording cannot be written as {path.name!r}",
        where=str(path),
        fix=f"end the name in {', '.join(ENDINGS)}",
    )


def _columns(recording: Recording) -> dict[str, Array]:
    """Return `time` and every channel, all on one clock, shape (samples,) each."""
    channels = recording.channels
    first = next((one for one in channels.values() if not one.hold), next(iter(channels.values())))
    return {"time": first.time} | {
        name: channel.value if np.array_equal(channel.time, first.time) else channel.at(first.time)
        for name, channel in channels.items()
    }


def _csv(columns: dict[str, Array]) -> bytes:
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    # Python's shortest text of a float reads back as the same float.
    names = [f'"{name}"' if re.search("[,;\t]", name) else name for name in columns]
    lines = [",".join(names), *(",".join(map(repr, row)) for row in rows)]
    return ("\n".join(lines) + "\n").encode()


def _parquet(columns: dict[str, Array]) -> bytes:
    import pyarrow
    from pyarrow import parquet

    sink = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), sink, compression="zstd")
    return sink.getvalue()


def _npz(recording: Recording) -> bytes:
    channels = recording.channels
    first = next((one for one in channels.values() if not one.hold), next(iter(channels.values())))
    arrays = {"time": first.time}
    for name, channel in channels.items():
        arrays[name] = channel.value
        if not np.array_equal(channel.time, first.time):
            arrays[f"{name}{CLOCK}"] = channel.time
    sink = io.BytesIO()
    np.savez_compressed(sink, allow_pickle=False, **arrays)
    return sink.getvalue()
