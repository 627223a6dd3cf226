"""Writing files so that a killed run leaves nothing half-written, and hashing them."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from morph.errors import OutputError
from morph.regular_file import open_regular


def write_whole(path: Path, content: str | bytes, *, durable: bool = True) -> Path:
    """Write a file under a temporary name beside it, then rename it into place.

    A reader sees the old file or the new one, never a part: rename within one
    folder is atomic on POSIX file systems.

    Args:
        path: The file.
        content: What it will hold.
        durable: Whether it is on the disk when this returns, which takes some milliseconds.
            If not, a power failure may leave it empty.

    Returns:
        The path written.

    Raises:
        OutputError: The folder cannot be written to, or the disk is full.
    """
    data = content.encode() if isinstance(content, str) else content
    temporary: str | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}",
            where=str(path),
            fix="choose a folder that exists, can be written to and has room",
        ) from error
    finally:
        if temporary is not None and os.path.exists(temporary):
            os.unlink(temporary)
    return path


def sha256(*parts: bytes | str | Path) -> str:
    """Return the SHA-256 of texts, bytes and files' contents in order, as hex."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, Path):
            with open_regular(part) as file:
                while piece := file.read(1 << 20):
                    digest.update(piece)
        else:
            digest.update(part.encode() if isinstance(part, str) else part)
    return digest.hexdigest()


def sha256_of_files(paths: Iterable[Path]) -> str:
    """Return one SHA-256 over several files' contents, in the order given."""
    return sha256(*paths)
