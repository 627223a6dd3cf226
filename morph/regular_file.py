"""Opening files that a user names: regular files only, never waited for, read up to a limit."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a character device"),
    (stat.S_ISBLK, "a block device"),
)
"""What a path may lead to instead of a file, in words."""


def open_regular(path: Path, most: int | None = None, *, follow: bool = True) -> BinaryIO:
    """Return a regular file, open for reading bytes.

    Args:
        path: The file.
        most: Most bytes that it may have; None if its reader takes it in piece by piece.
        follow: Whether the path may be a link to a regular file.

    Raises:
        OSError: It is missing, cannot be read, is larger, or is a folder, a pipe, a socket or a
            device. `strerror` says so in words; nothing was waited for.
        ValueError: The path holds a null character.
    """
    try:
        # Before it is opened: opening a device may already do something to it.
        _check(os.stat(path, follow_symlinks=follow), path)
        # A pipe that takes the file's place after this look would be waited for without it.
        flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | (0 if follow else os.O_NOFOLLOW)
        handle = os.open(path, flags)
    except FileNotFoundError as error:
        if os.path.islink(path):
            leads = f"it is a link to {os.readlink(path)}, which is not there"
            raise FileNotFoundError(errno.ENOENT, leads, str(path)) from error
        raise
    file = os.fdopen(handle, "rb")
    try:
        about = os.fstat(handle)
        _check(about, path)
        if most is not None and about.st_size > most:
            raise _too_large(path, f"it has {about.st_size} bytes, and {most} are read at most")
    except BaseException:
        file.close()
        raise
    return file


def read_regular(path: Path, most: int, *, follow: bool = True) -> bytes:
    """Return the bytes of a regular file.

    Args:
        path: The file.
        most: Most bytes that it may have.
        follow: Whether the path may be a link to a regular file.

    Raises:
        OSError: As for `open_regular`.
        ValueError: The path holds a null character.
    """
    with open_regular(path, most, follow=follow) as file:
        # Files of the kernel say that they have no bytes, and another program may append.
        content = file.read(most + 1)
    if len(content) > most:
        raise _too_large(path, f"it has more than the {most} bytes that are read at most")
    return content


def _check(about: os.stat_result, path: Path) -> None:
    if stat.S_ISDIR(about.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder, no file", str(path))
    if not stat.S_ISREG(about.st_mode):
        kind = next((words for holds, words in KINDS if holds(about.st_mode)), "a special file")
        raise OSError(errno.EINVAL, f"it is {kind}, no regular file", str(path))


def _too_large(path: Path, words: str) -> OSError:
    return OSError(errno.EFBIG, words, str(path))
