"""Lines over pipes, with a timeout on every read and write."""

from __future__ import annotations

import os
import queue
import select
import threading
import time

from morph.policy_transfer.live.connection import Heard
from morph.policy_transfer.live.protocol import LONGEST_LINE, parsed

MOST_WAITING = 10_000
"""Most messages that wait to be heard; then the other side has to wait."""

CHUNK = 2**16
"""Bytes that are read at once."""

SHOWN = 60
"""Bytes that are shown of a line that cannot be read."""


class Reader:
    """Reads messages from a file descriptor in a thread of its own, and closes it at its end."""

    def __init__(self, descriptor: int) -> None:
        self._queue: queue.Queue[Heard] = queue.Queue(MOST_WAITING)
        self._descriptor, self._wanted = descriptor, True
        threading.Thread(target=self._read, daemon=True).start()

    def hear(self, seconds: float) -> Heard | None:
        """Return the next message, waiting at most so long."""
        try:
            return self._queue.get(timeout=seconds) if seconds > 0 else self._queue.get_nowait()
        except queue.Empty:
            return None

    def forget(self) -> None:
        """Throw away what waits to be heard, but not that nothing more will come."""
        for _ in range(self._queue.qsize()):
            heard = self.hear(0.0)
            if heard is not None and heard.ended:
                self._queue.put(heard)
                return

    def close(self) -> None:
        """Listen no more: what still comes is thrown away."""
        self._wanted = False

    def _put(self, heard: Heard) -> None:
        while self._wanted:
            try:
                self._queue.put(heard, timeout=0.2)
                return
            except queue.Full:
                continue

    def _read(self) -> None:
        rest, skipping = b"", False
        while True:
            try:
                chunk = os.read(self._descriptor, CHUNK)
            except OSError:
                chunk = b""
            at = time.monotonic()
            if not chunk:
                os.close(self._descriptor)
                self._put(Heard(at=at, ended="it closed its output"))
                return
            *lines, rest = (rest + chunk).split(b"\n")
            for line in lines:
                if skipping or len(line) > LONGEST_LINE:
                    self._put(Heard(at=at, unreadable=f"a line over {LONGEST_LINE} bytes"))
                    skipping = False
                elif line.strip():
                    self._put(_heard(line, at))
            if len(rest) > LONGEST_LINE:
                # What is thrown away must not be kept until its end comes.
                rest, skipping = b"", True


def _heard(line: bytes, at: float) -> Heard:
    statement = parsed(line)
    if statement is None:
        return Heard(at=at, unreadable=f"{line[:SHOWN]!r} is no JSON object")
    return Heard(at=at, said=statement)


class Tail:
    """Keeps the last that a file descriptor says, in a thread that closes it at its end."""

    def __init__(self, descriptor: int, most: int = 2000) -> None:
        self._kept, self._most, self._descriptor = b"", most, descriptor
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def text(self) -> str:
        """Return the last line that was said; empty if none was."""
        self._thread.join(timeout=0.2)
        lines = self._kept.decode(errors="replace").strip().splitlines()
        return lines[-1].strip() if lines else ""

    def _read(self) -> None:
        while True:
            try:
                chunk = os.read(self._descriptor, CHUNK)
            except OSError:
                chunk = b""
            if not chunk:
                os.close(self._descriptor)
                return
            self._kept = (self._kept + chunk)[-self._most :]


def write(descriptor: int, data: bytes, seconds: float) -> bool:
    """Return whether all of some bytes could be written in time to a non-blocking descriptor."""
    until = time.monotonic() + seconds
    while data:
        try:
            data = data[os.write(descriptor, data) :]
        except BlockingIOError:
            left = until - time.monotonic()
            if left <= 0.0:
                return False
            select.select([], [descriptor], [], left)
        except OSError:
            return False
    return True
