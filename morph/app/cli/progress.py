"""How far a search is, on the error stream: a line that changes, or one for each trial."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from morph.search.search import Trial


@contextmanager
def progress(quiet: bool, what: str) -> Iterator[Callable[[Trial], None]]:
    """Lend what is told each trial.

    Args:
        quiet: Whether nothing is shown.
        what: What is searched for.
    """
    if quiet:
        yield lambda trial: None
        return
    if not sys.stderr.isatty():
        yield _line
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(what, total=None)
        yield lambda trial: shown.update(task, description=f"{what}: {in_words(trial)}")


def in_words(trial: Trial) -> str:
    """Return a trial in a line."""
    from morph.app.cli.console import harmless

    words = f"trial {trial.number}, loss {trial.loss:.4g}, success {100.0 * trial.success:.0f} %"
    if trial.experience > 0.0:
        words += f", {trial.experience:.4g} s of experience"
    words += f", {trial.seconds:.1f} s"
    return harmless(f"{words}; {trial.note}" if trial.note else words)


def _line(trial: Trial) -> None:
    sys.stderr.write(in_words(trial) + "\n")
    sys.stderr.flush()
