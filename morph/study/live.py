"""Live display of a study's progress on stderr: a table on a terminal, else plain lines."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from morph.study.progress import Progress, Watch, ignore
from morph.study.store import FINAL, Result

PAUSE = 10.0
"""Least seconds between two plain lines, so that a log stays short."""


@contextmanager
def live(*, quiet: bool = False) -> Iterator[Watch]:
    """Yield a callback for `morph.study.run.run` that shows the progress.

    Args:
        quiet: Whether to show nothing.
    """
    if quiet:
        yield ignore
        return
    if not sys.stderr.isatty():
        yield _Lines()
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(stderr=True), refresh_per_second=4) as display:

        def watch(progress: Progress, result: Result | None) -> None:
            display.update(_table(progress))
            if result is not None and result.status not in FINAL:
                display.console.print(in_words(result), highlight=False, markup=False)

        yield watch


def in_words(result: Result) -> str:
    """Return a cell's status, label and error in one line of printable letters, 500 at most."""
    why = f": {' '.join(str(result.error['what']).split())}" if result.error else ""
    line = f"{result.status}: {result.cell.label}{why}"
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)[:500]


def duration(seconds: float | None) -> str:
    """Return seconds as text, such as `2 min 00 s` or `1 h 01 min`; `?` for None."""
    if seconds is None:
        return "?"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest:02d} s"


def _table(progress: Progress) -> Any:
    from rich.table import Table

    table = Table(caption=_silence(progress) if progress.silent else None)
    titles = ("done", "running", "failed", "workers lost", "cells/s", "left")
    for title in titles:
        table.add_column(title, justify="right")
    table.add_row(*_entries(progress))
    return table


def _silence(progress: Progress) -> str:
    return f"the scheduler has not answered for {progress.silent:.0f} s"


def _entries(progress: Progress) -> tuple[str, ...]:
    return (
        f"{progress.reused + progress.done} of {progress.total}",
        str(progress.running),
        str(progress.failed),
        str(progress.worker_deaths),
        f"{progress.rate:.3g}",
        duration(progress.left),
    )


class _Lines:
    """Prints a line of progress every `PAUSE`, one at the end, and one for each failed cell."""

    def __init__(self) -> None:
        self.next_line = self.next_silence = 0.0

    def __call__(self, progress: Progress, result: Result | None) -> None:
        if result is not None and result.status not in FINAL:
            self._write(in_words(result))
        if progress.silent and time.monotonic() >= self.next_silence:
            self._write(_silence(progress))
            self.next_silence = time.monotonic() + PAUSE
        finished = progress.reused + progress.done == progress.total
        if finished or (progress.done and time.monotonic() >= self.next_line):
            done, running, failed, deaths, rate, left = _entries(progress)
            self._write(
                f"{done} done, {running} running, {failed} failed, {deaths} workers lost, "
                f"{rate} cells/s, {left} left"
            )
            self.next_line = time.monotonic() + PAUSE

    @staticmethod
    def _write(line: str) -> None:
        sys.stderr.write(line + "\n")
        sys.stderr.flush()
