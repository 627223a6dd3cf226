"""A sign of life on the error stream where no terminal shows what is being done."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from morph.app.cli.stages import Stages, stages

EVERY = 5.0
"""A stage is told once it has lasted so long, s: short ones would only fill the log."""

AGAIN = 60.0
"""A stage that goes on is told once more after so long, s."""


@contextmanager
def beating(quiet: bool, *, every: float = EVERY, again: float = AGAIN) -> Iterator[Stages]:
    """Lend where progress is told; a pipe or a file is told of each stage that takes long.

    Args:
        quiet: Whether nothing is shown.
        every: How long a stage lasts before it is told, s.
        again: After how long it is told once more, s.
    """
    with stages(quiet) as told:
        if quiet or sys.stderr.isatty():
            yield told
            return
        beat = _Beat(told, every, again)
        beat.start()
        try:
            yield Stages(now=beat.now, line=told.line)
        finally:
            beat.stop()


class _Beat(threading.Thread):
    """Tells what is being done, if that takes long."""

    def __init__(self, told: Stages, every: float, again: float) -> None:
        super().__init__(daemon=True)
        self._told, self._every, self._again = told, every, again
        self._over = threading.Event()
        self._began = time.monotonic()
        # What is done, since when, and when it was last told: replaced as a whole.
        self._stage: tuple[str, float] = ("", self._began)

    def now(self, said: str) -> None:
        if said != self._stage[0]:
            self._stage = (said, time.monotonic())

    def run(self) -> None:
        last, at = None, 0.0
        while not self._over.wait(self._every / 10.0):
            stage, now = self._stage, time.monotonic()
            due = now - at >= self._again if stage == last else now - stage[1] >= self._every
            if stage[0] and due:
                self._told.line(f"[{now - self._began:.0f} s] {stage[0]}")
                last, at = stage, now

    def stop(self) -> None:
        self._over.set()
        self.join()
