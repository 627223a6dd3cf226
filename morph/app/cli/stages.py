"""How far a loop is, on the error stream: what it does now, and what each trial showed."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple


class Stages(NamedTuple):
    """Where progress is told."""

    now: Callable[[str], None]
    """What is being done now: one line that changes; told to a terminal alone."""
    line: Callable[[str], None]
    """What stays."""


@contextmanager
def stages(quiet: bool) -> Iterator[Stages]:
    """Lend where progress is told.

    Args:
        quiet: Whether nothing is shown.
    """
    if quiet:
        yield Stages(now=lambda _: None, line=lambda _: None)
        return
    if not sys.stderr.isatty():
        yield Stages(now=lambda _: None, line=_line)
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task("beginning", total=None)
        yield Stages(
            now=lambda statement: shown.update(task, description=_harmless(statement)),
            line=lambda statement: shown.console.print(
                _harmless(statement), highlight=False, markup=False
            ),
        )


def _line(text: str) -> None:
    sys.stderr.write(_harmless(text) + "\n")
    sys.stderr.flush()


def _harmless(text: str) -> str:
    from morph.app.cli.console import harmless

    return harmless(text)
