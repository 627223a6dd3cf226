"""Whether others could replace a file whose code is to be run."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def changed_by_others(path: Path) -> str:
    """Return by what others could change a file or what is in a folder; empty if they cannot.

    Nobody but this user and root may own it or a folder above it, nor write to them; a folder
    above it may be written to where only owners remove what is in it, as in `/tmp`.

    Raises:
        OSError: It is not there.
    """
    real = path.resolve(strict=True)
    folder = real if real.is_dir() else real.parent
    for each in (real, *real.parents):
        about = each.stat()
        if about.st_uid not in (0, os.geteuid()):
            return f"{each} belongs to user {about.st_uid}"
        kept = bool(about.st_mode & stat.S_ISVTX) and each not in (real, folder)
        if about.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and not kept:
            return f"others may write to {each}"
    return ""


def make_private(folder: Path) -> None:
    """Make a folder, and those above it that are missing, for this user alone.

    Raises:
        OSError: It cannot be made.
    """
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    for each in reversed(missing):
        each.mkdir(mode=0o700, exist_ok=True)
