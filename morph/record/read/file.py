"""The bytes of a file, or an error of ours."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from morph.errors import RecordingError

MOST_BYTES = 2 * 1024**3
"""The most that a file's numbers, or its messages, may take once they are unpacked."""
MOST_COLUMNS = 10_000
"""The most columns, topics or data sets of a file."""


def read_bytes(path: Path) -> bytes:
    """Return a file's bytes.

    Raises:
        RecordingError: It is missing, empty, or cannot be read.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    if not data:
        raise _empty(path)
    return data


def size_of(path: Path) -> int:
    """Return a file's size, in bytes, for readers that do not take it in as a whole.

    Raises:
        RecordingError: It is missing, empty, or no plain file.
    """
    try:
        size = path.stat().st_size
        plain = path.is_file()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    if not plain:
        raise RecordingError(
            "this is no plain file", where=str(path), fix="name the file that the logger wrote"
        )
    if not size:
        raise _empty(path)
    return size


def hash_of(paths: Iterable[Path]) -> str:
    """Return one SHA-256 over files in the order given; a folder stands for all files in it.

    It is that of `morph.files.sha256_of_files`, which takes files in as a whole.
    """
    digest = hashlib.sha256()
    for path in paths:
        inside = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
        for one in inside:
            with one.open("rb") as file:
                while part := file.read(1 << 20):
                    digest.update(part)
    return digest.hexdigest()


def _unreadable(path: Path, error: OSError | ValueError) -> RecordingError:
    return RecordingError(
        f"the file cannot be read: {getattr(error, 'strerror', None) or error}",
        where=str(path),
        fix="check the path and, in a recording.toml, its root; or fetch the file first",
    )


def _empty(path: Path) -> RecordingError:
    return RecordingError(
        "the file is empty", where=str(path), fix="record the episode again, or leave it out"
    )
