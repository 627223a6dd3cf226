"""The lock of a run folder: one process at a time works in it."""

from __future__ import annotations

import fcntl
import hashlib
import os
import socket
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from morph.errors import OutputError

LOCK = ".morph.lock"
"""File in a run folder that is there and locked while a process works in it."""

OWNED = ".morph.files"
"""File in a folder that names the files there which a command wrote; all others are the user's."""

MOST_WORDS = 300
"""Most bytes of a lock that are read: who holds it."""


@contextmanager
def lock_run_folder(folder: Path, *, beside: bool = False) -> Iterator[None]:
    """Hold a run folder, so that no other process works in it.

    The lock is released when this ends, or the process does, however it ends. A folder that was
    made for it is removed again if nothing was put into it.

    Args:
        folder: The folder; it need not exist.
        beside: Whether the lock stands beside the folder, which is then not made: for one that is
            replaced whole.

    Raises:
        OutputError: Another process holds it, or nothing can be locked there.
    """
    path = lock_of(folder, beside=beside)
    made = [each for each in (path.parent, *path.parent.parents) if not each.exists()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = _lock(path, folder)
    except (FileExistsError, NotADirectoryError) as error:
        raise OutputError(
            "it cannot be locked: it is a file, or lies below one",
            where=str(folder),
            fix="name a folder",
        ) from error
    except OSError as error:
        raise OutputError(
            f"it cannot be locked: {error.strerror or error}",
            where=str(folder),
            fix="name a folder that you may write to, on a file system that knows locks",
        ) from error
    try:
        yield
    finally:
        # Removed while it is held: whoever waits at the old file sees that it is gone.
        with suppress(OSError):
            path.unlink(missing_ok=True)
        os.close(handle)
        with suppress(OSError):
            for each in made:
                # Fails where something was put into it, and that ends it.
                each.rmdir()


def lock_of(folder: Path, *, beside: bool = False) -> Path:
    """Return the file that is locked while a process works in a folder.

    Args:
        folder: The folder.
        beside: Whether the lock stands beside it.
    """
    if not beside:
        return folder / LOCK
    place = folder.absolute()
    # The name may be as long as names can be: what is left of it is told apart by its hash.
    mark = hashlib.sha256(os.fsencode(place.name)).hexdigest()[:8]
    return place.with_name(f".{place.name[:40]}.{mark}.lock")


def _lock(path: Path, folder: Path) -> int:
    """Return a file that is locked for this process."""
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    while True:
        handle = os.open(path, flags, 0o644)
        try:
            about = os.fstat(handle)
            if not stat.S_ISREG(about.st_mode):
                raise OSError(0, f"{path} is no regular file")
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # Between opening and locking, the one before may have ended and removed the file.
            if _is_at(about, path):
                os.ftruncate(handle, 0)
                os.pwrite(handle, _words().encode(), 0)
                return handle
        except BlockingIOError as error:
            who = os.pread(handle, MOST_WORDS, 0).decode(errors="replace").strip()
            os.close(handle)
            raise _taken(folder, who) from error
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def _is_at(about: os.stat_result, path: Path) -> bool:
    try:
        return os.path.samestat(about, os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


def _words() -> str:
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    return f"process {os.getpid()} on {socket.gethostname()} since {since}\n"


def _taken(folder: Path, who: str) -> OutputError:
    # It is locked before it says by whom.
    number = who.split()[1] if who.startswith("process ") and who.split()[1:] else ""
    end = f", or end it by `kill {number}`" if number.isdecimal() else ""
    return OutputError(
        f"another morph works in this folder now: {who or 'a process that has just begun'}",
        where=str(folder),
        fix=f"wait until it has ended{end}; or name another folder",
    )
