"""Whether the file that an option names can be written, told before any work is done."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

from morph.errors import OutputError


def check_output_file(option: str, name: str, endings: Sequence[str]) -> None:
    """Check that a file of one of some kinds can be written.

    Args:
        option: The option that names it.
        name: What it was given.
        endings: Endings of the kinds that it may be of.

    Raises:
        OutputError: It is of another kind, or nothing can be written there.
    """
    path = Path(name)
    # A name that is all ending, such as `.mp4`, is a hidden file without one.
    if not path.name.lower().endswith(tuple(endings)) or path.name.lower() in endings:
        raise OutputError(
            f"{name!r} does not say which kind of file to write",
            where=option,
            fix=f"end the name in {', '.join(endings)}",
        )
    try:
        if path.is_dir():
            raise OutputError("this is a folder", where=name, fix=f"name a file for {option}")
        standing = next(parent for parent in path.absolute().parents if parent.exists())
        os.rmdir(tempfile.mkdtemp(dir=standing, prefix=".morph-"))
    except OSError as error:
        raise OutputError(
            f"nothing can be written there: {error.strerror or error}",
            where=name,
            fix="name a folder that you may write to",
        ) from error
