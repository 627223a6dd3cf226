"""A link over folders that both sides see: on one machine, a shared disk, or a stick."""

from __future__ import annotations

import itertools
import os
import time
from pathlib import Path

from morph.errors import LinkDropped, OutputError
from morph.files import write_whole
from morph.policy_transfer.link.link import MessageLink
from morph.policy_transfer.link.message import MOST_BYTES
from morph.regular_file import open_regular

ENDING = ".message"
"""The ending of a file that holds a message."""

MOST_AT_ONCE = 1000
"""Most messages that are taken at once."""


class FolderLink(MessageLink):
    """Writes each message to a file of one folder, and takes those of another away.

    Args:
        sends: The folder that the other side receives from.
        receives: The folder that the other side sends to.
    """

    def __init__(self, sends: Path, receives: Path) -> None:
        self._sends, self._receives = sends, receives
        self._count = itertools.count()

    def send(self, message: bytes) -> None:
        """Write a message to a file of its own.

        Raises:
            LinkDropped: The folder is not there, or is full.
        """
        name = f"{time.time_ns():020d}-{os.getpid()}-{next(self._count):06d}{ENDING}"
        if not self._sends.is_dir():
            # A disk that is not mounted must not be written beneath.
            raise _down(self._sends, "is not there")
        try:
            write_whole(self._sends / name, message)
        except OutputError as error:
            raise _down(self._sends, error.what) from error

    def receive(self) -> list[bytes]:
        """Return what was written since, the oldest first, and remove it.

        Raises:
            LinkDropped: The folder cannot be read.
        """
        results = []
        try:
            files = sorted(x for x in self._receives.iterdir() if x.name.endswith(ENDING))
            for file in files[:MOST_AT_ONCE]:
                # What is no regular file is nobody's message; a pipe would be waited for.
                if file.name.startswith(".") or not file.is_file():
                    continue
                with open_regular(file) as content:
                    results.append(content.read(MOST_BYTES + 1))
                file.unlink()
        except OSError as error:
            if results:
                return results
            raise _down(self._receives, error.strerror or str(error)) from error
        return results


def _down(folder: Path, what: str) -> LinkDropped:
    return LinkDropped(what, where=str(folder), fix="mount or make it; what waits is sent then")
