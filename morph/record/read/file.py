"""A file that is open, or an error of ours; and the hash of files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from morph.errors import RecordingError
from morph.regular_file import open_regular


def opened(path: Path, most: int | None = None) -> BinaryIO:
    """Return a file that is not empty, open for reading bytes.

    Args:
        path: The file.
        most: Most bytes that it may have; None if its reader takes it in piece by piece.

    Raises:
        RecordingError: It is missing, empty, too large, no regular file, or cannot be read.
    """
    try:
        file = open_regular(path, most)
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"the file cannot be read: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="check the path and, in a recording.toml, its root; name the plain file that the "
            "logger wrote, or fetch it first",
        ) from error
    if not os.fstat(file.fileno()).st_size:
        file.close()
        raise RecordingError(
            "the file is empty", where=str(path), fix="record the episode again, or leave it out"
        )
    return file


def read_bytes(path: Path, most: int) -> bytes:
    """Return the bytes of a file that has no more than `most`.

    Raises:
        RecordingError: As for `opened`.
    """
    with opened(path, most) as file:
        return file.read(most)


def size_of(path: Path) -> int:
    """Return a file's size, in bytes, for readers that open it by its name.

    Raises:
        RecordingError: It is missing, empty, no regular file, or cannot be read.
    """
    with opened(path) as file:
        return os.fstat(file.fileno()).st_size


def hash_of(paths: Iterable[Path]) -> str:
    """Return one SHA-256 over files in the order given; a folder stands for all files in it.

    It is that of `morph.files.sha256_of_files`.

    Raises:
        RecordingError: One cannot be read.
    """
    digest = hashlib.sha256()
    for path in paths:
        inside = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
        for one in inside:
            try:
                with open_regular(one) as file:
                    while part := file.read(1 << 20):
                        digest.update(part)
            except OSError as error:
                raise RecordingError(
                    f"the file cannot be read: {error.strerror or error}",
                    where=str(one),
                    fix="allow reading it, or take it out of the bag's folder",
                ) from error
    return digest.hexdigest()
