"""A file to which lines are only ever added, each on the disk before anything relies on it."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from typing import IO

from morph.arrays import JSON
from morph.errors import TransferError
from morph.files import sha256, write_whole

HASH = 64
"""Characters of a hash, which stands before each entry."""


class Journal:
    """Entries that survive a kill: what was added is there, and what was half added is not.

    Each line is the SHA-256 of an entry, a space and the entry as JSON. A last line that is not
    whole is what a kill leaves, and is cut off; one that is spoilt before the end is an error,
    because what follows it is then in doubt.

    Args:
        path: The file, which one process at a time may hold.

    Raises:
        TransferError: The file is spoilt, held by another process, or cannot be used.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            # A file of its own is locked, because the journal's is replaced at times.
            self._lock: IO[bytes] = path.with_name(f"{path.name}.lock").open("ab")
        except OSError as error:
            raise self._refused(
                f"cannot be used: {error.strerror or error}", "choose another folder"
            ) from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._file = self._opened()
            self.entries = self._read()
        except BlockingIOError as error:
            self._lock.close()
            raise self._refused(
                "is held by another process", "let one process at a time use this folder"
            ) from error
        except OSError as error:
            self._lock.close()
            raise self._refused(
                f"cannot be used: {error.strerror or error}", "choose another folder"
            ) from error
        except TransferError:
            self.close()
            raise

    def _opened(self) -> IO[bytes]:
        file = self.path.open("a+b")
        # A new file's name is on the disk only when its folder is.
        folder = os.open(self.path.parent, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)
        return file

    def _read(self) -> list[JSON]:
        """Return all whole entries, and cut off what a kill left half written."""
        self._file.seek(0)
        data = self._file.read()
        entries: list[JSON] = []
        good = 0
        for number, line in enumerate(data.splitlines(keepends=True), 1):
            entry = _entry(line)
            if entry is None:
                if good + len(line) < len(data):
                    raise self._refused(
                        f"line {number} is spoilt, and lines follow it",
                        "restore the file, or remove it to begin anew",
                    )
                break
            entries.append(entry)
            good += len(line)
        if good < len(data):
            self._file.truncate(good)
            self._sync()
        return entries

    def add(self, entry: JSON) -> None:
        """Add an entry; it is on the disk when this returns.

        Raises:
            TransferError: The disk is full, or the file cannot be written.
        """
        size = os.fstat(self._file.fileno()).st_size
        try:
            self._file.write(_line(entry))
            self._sync()
        except OSError as error:
            # A half-written entry must not stand before the next one.
            self._file.truncate(size)
            raise self._refused(
                f"cannot be written: {error.strerror or error}", "make room on the disk"
            ) from error
        self.entries.append(entry)

    def rewrite(self, entries: list[JSON]) -> None:
        """Replace all entries, so that a file does not grow for ever; a kill leaves old or new."""
        write_whole(self.path, b"".join(_line(each) for each in entries))
        self._file.close()
        self._file = self._opened()
        self.entries = list(entries)

    def close(self) -> None:
        """Let another process have it."""
        self._file.close()
        self._lock.close()

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())

    def _refused(self, what: str, fix: str) -> TransferError:
        return TransferError(what, where=str(self.path), fix=fix)


def _line(entry: JSON) -> bytes:
    body = json.dumps(entry, allow_nan=False)
    return f"{sha256(body)} {body}\n".encode()


def _entry(line: bytes) -> JSON | None:
    body = line[HASH + 1 : -1]
    whole = line.endswith(b"\n") and line[:HASH] == sha256(body).encode()
    entry = json.loads(body) if whole else None
    return entry if isinstance(entry, dict) else None
