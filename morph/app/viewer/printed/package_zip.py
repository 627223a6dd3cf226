"""A print package as one zip file, for download."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

from morph.errors import OutputError

MOST_BYTES = 300_000_000
"""Of all files together: a browser and this machine hold them in memory."""


def zipped(folder: Path, name: str) -> bytes:
    """Return the files of a package as a ZIP, all of them under one name.

    Links are left out: they may lead anywhere.

    Raises:
        OutputError: A file cannot be read, or there is too much.
    """
    files = sorted(path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    packed = io.BytesIO()
    total = 0
    try:
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in files:
                if not path.resolve().is_relative_to(folder.resolve()):
                    continue
                total += path.stat().st_size
                if total > MOST_BYTES:
                    raise OutputError(
                        f"it has more than {MOST_BYTES / 1e6:.0f} MB",
                        where=str(folder),
                        fix="copy the folder by hand",
                    )
                archive.write(path, f"{name}/{path.relative_to(folder).as_posix()}")
    except OSError as error:
        raise OutputError(
            f"a file cannot be read: {error.strerror or error}",
            where=str(folder),
            fix="copy the folder by hand",
        ) from error
    return packed.getvalue()
