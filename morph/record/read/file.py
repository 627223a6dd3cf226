"""The bytes of a file, or an error of ours."""

from __future__ import annotations

from pathlib import Path

from morph.errors import RecordingError


def read_bytes(path: Path) -> bytes:
    """Return a file's bytes.

    Raises:
        RecordingError: It is missing, empty, or cannot be read.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"the file cannot be read: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="check the path and, in a recording.toml, its root; or fetch the file first",
        ) from error
    if not data:
        raise RecordingError(
            "the file is empty", where=str(path), fix="record the episode again, or leave it out"
        )
    return data
