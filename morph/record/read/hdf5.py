"""Reading HDF5 files, in a process of its own: on damaged bytes HDF5 may end the one it runs in."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.limits import MEMORY, most_unpacked
from morph.record.read.file import size_of
from morph.record.read.table import Table
from morph.record.recording import Note

MOST_LINE = 64 * 1024**2
"""The longest line of an answer, in bytes: ten thousand names and what is said of them."""

# Neither the user's settings nor the folder that they stand in have a say in what is imported.
COMMAND = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from morph.record.read.hdf5_child import main; main()"
)


def read_hdf5(path: Path, key: str | None = None, wanted: Collection[str] | None = None) -> Table:
    """Return the data sets of an HDF5 file as columns, named by their paths: `arm/position`.

    Args:
        path: The file.
        key: The group whose data sets are the columns of one episode; or a data
            set of shape (rows, columns), whose columns have numbers only. None:
            the whole file.
        wanted: The columns to read; None for all. What holds no plain numbers of
            one or two dimensions is no column.

    Raises:
        RecordingError: The file is missing, empty or damaged, has no such group or
            column, reaches outside itself, or declares absurd sizes.
    """
    names = None if wanted is None else sorted(wanted)
    ((_, table),) = _ask(path, {"key": key, "wanted": names, "every": False})
    return table


def read_episodes(path: Path) -> tuple[tuple[str | None, Table], ...]:
    """Return the columns of each episode in an HDF5 file, with its key.

    A file whose top level has groups and no numbers has an episode in each group;
    any other is one episode, and its key is None.

    Raises:
        RecordingError: As for `read_hdf5`.
    """
    return _ask(path, {"key": None, "wanted": None, "every": True})


def _ask(path: Path, request: dict[str, Any]) -> tuple[tuple[str | None, Table], ...]:
    """Return what the process finds in a file."""
    most = most_unpacked(size_of(path))
    try:
        process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-B", "-X", "utf8", "-c", COMMAND, json.dumps(_paths())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # Threads that only reckon would take address space from the limit.
            env={key: os.environ[key] for key in ("LD_LIBRARY_PATH", MEMORY) if key in os.environ}
            | {"OPENBLAS_NUM_THREADS": "1"},
            start_new_session=True,
        )
    except OSError as error:
        raise RecordingError(
            f"reading HDF5 needs a process, and there is none: {error.strerror or error}",
            where=str(path),
            fix="close other programs, or save the recording as NPZ",
        ) from error
    with process:
        try:
            if process.stdin is None or process.stdout is None:
                return ()
            with contextlib.suppress(BrokenPipeError), process.stdin as stdin:
                stdin.write(json.dumps({"path": str(path), **request}).encode())
            return tuple(_tables(process.stdout, path, most))
        finally:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)


def _tables(answer: Any, path: Path, most: int) -> Iterator[tuple[str | None, Table]]:
    """Give each episode of an answer.

    Raises:
        RecordingError: The answer is an error, or breaks off.
    """
    while "end" not in (line := _line(answer, path)):
        columns = [_numbers(answer, path, most) for _ in line["names"]]
        names = tuple(line["names"])
        if not line["named"]:
            names = ()
            columns = list(columns[0].T) if columns[0].ndim == 2 else columns
        notes = (Note(what=line["note"], where=str(path)),) if line["note"] else ()
        yield line["key"], Table(path=path, names=names, columns=tuple(columns), notes=notes)


def _numbers(answer: BinaryIO, path: Path, most: int) -> Array:
    """Return the next column of an answer."""
    shape = tuple(_line(answer, path)["shape"])
    if math.prod(shape) * 8 > most:
        raise _damaged(path, f"a column of {shape} numbers")
    numbers = np.empty(shape)
    left = numbers.reshape(-1).view(np.uint8).data
    while left:
        count = answer.readinto(left)  # type: ignore[attr-defined]
        if not count:
            raise _damaged(path, "HDF5 gives up on it")
        left = left[count:]
    return numbers


def _line(answer: BinaryIO, path: Path) -> dict[str, Any]:
    """Return the next line of an answer."""
    text = answer.readline(MOST_LINE)
    if not text.endswith(b"\n"):
        raise _damaged(path, "HDF5 gives up on it")
    line: dict[str, Any] = json.loads(text)
    if "what" in line:
        if "fix" not in line:
            raise _damaged(path, line["what"])
        raise RecordingError(line["what"], where=line["where"], fix=line["fix"])
    return line


def _damaged(path: Path, what: str) -> RecordingError:
    return RecordingError(
        f"the file is truncated, damaged or not HDF5: {what}",
        where=str(path),
        fix="copy the file again, or write it again",
    )


def _paths() -> list[str]:
    """Return where modules are found; never the folder that the user happens to stand in."""
    home = str(Path(__file__).resolve().parents[3])
    return [*(path for path in sys.path if path), home]
