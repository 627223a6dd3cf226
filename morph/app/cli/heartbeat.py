"""Progress on the error stream where it is no terminal."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from morph.app.cli.stages import Stages, stages

EVERY = 5.0
"""What is done is told when nothing was told for so long, s: all stages would fill the log."""

AGAIN = 60.0
"""A stage that goes on is told once more when nothing was told for so long, s."""


@contextmanager
def beating(quiet: bool, *, every: float = EVERY, again: float = AGAIN) -> Iterator[Stages]:
    """Lend where progress is told; a pipe or a file is told now and then what is done.

    Args:
        quiet: Whether nothing is shown.
        every: For how long nothing is told before it is told what is done, s.
        again: The same for a stage that was told already, s.
    """
    with stages(quiet) as progress:
        if quiet or sys.stderr.isatty():
            yield progress
            return
        beat = _Beat(progress, every, again)
        beat.start()
        try:
            yield Stages(now=beat.now, line=beat.line)
        finally:
            beat.stop()


class _Beat(threading.Thread):
    """Tells what is being done when nothing was told for long."""

    def __init__(self, progress: Stages, every: float, again: float) -> None:
        super().__init__(daemon=True)
        self._told, self._every, self._again = progress, every, again
        self._over = threading.Event()
        self._began = self._last = time.monotonic()
        self._stage = ""

    def now(self, text: str) -> None:
        self._stage = text

    def line(self, text: str) -> None:
        self._last = time.monotonic()
        self._told.line(text)

    def run(self) -> None:
        before = ""
        while not self._over.wait(self._every / 10.0):
            stage, now = self._stage, time.monotonic()
            if stage and now - self._last >= (self._again if stage == before else self._every):
                self.line(f"[{now - self._began:.0f} s] {stage}")
                before = stage

    def stop(self) -> None:
        self._over.set()
        self.join()
