"""Resume an interrupted search from a checkpoint that may be damaged."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from morph.app.cli.search_checkpoint import STATE, Before
from morph.errors import OutputError, StateError

SPOILT = (
    *(StateError, LookupError, ValueError, TypeError),
    *(AttributeError, ArithmeticError, RuntimeError),
)
"""What a search meets that goes on from other arrays than those that it kept."""


@contextmanager
def going_on(out: Path, before: Before) -> Iterator[None]:
    """Say of what fails within that the state in the folder is to blame, if there was one.

    Raises:
        OutputError: The search cannot go on from it.
    """
    try:
        yield
    except SPOILT as error:
        if before.state is None:
            raise
        statement = (
            error.what if isinstance(error, StateError) else f"{type(error).__name__}: {error}"
        )
        raise OutputError(
            f"the search cannot go on from what is in it: {' '.join(statement.split())}",
            where=str(out / STATE),
            fix="begin anew by --fresh, or name a new folder",
        ) from error
