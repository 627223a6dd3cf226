"""Results of a study on disk: one JSON file a cell."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from morph.arrays import JSON
from morph.errors import OutputError
from morph.files import write_whole
from morph.regular_file import read_regular
from morph.study.cell import Cell, identity_of
from morph.study.encoding import decode_row, encode_row

CELLS = "cells"
SCHEMA = "morph.cell/1"
"""Name and version of the schema of a cell's file."""

Status = Literal["done", "refused", "failed", "quarantined"]
"""`done`: the function returned a row. `refused`: it raised an error in three parts (`what`,
`where`, `fix`), as a `MorphError` has, and would again.
`failed`: it raised another error. `quarantined`: its worker died in both attempts."""

MAX_BYTES = 1_000_000_000
"""Largest file read, bytes; the manifest of a million cells has some hundred million."""

FINAL = ("done", "refused")
"""Statuses that `--resume` does not run again."""


@dataclass(frozen=True, kw_only=True)
class Result:
    """Result of one cell."""

    cell: Cell
    """The cell."""
    status: Status
    """How it ended."""
    row: Any = None
    """Value that the function returned, as plain JSON data; None unless `done`."""
    error: JSON | None = None
    """`what`, with `where` and `fix` of a `MorphError` or `trace` of another; None if done."""
    seconds: float = 0.0
    """Wall time of the call, s."""
    host: str = ""
    """Name of the machine that ran it."""
    code: str = ""
    """Code hash of the cell when it ran (`Cell.code`)."""
    stale: bool = False
    """Whether `code` is not, or may not be, the hash of the code as it is now."""

    def as_json(self) -> JSON:
        """Return the content of its file."""
        return {
            "schema": SCHEMA,
            "identity": self.cell.identity,
            "function": self.cell.function,
            "case": self.cell.encoded,
            "status": self.status,
            "row": encode_row(self.row),
            "error": self.error,
            "seconds": self.seconds,
            "host": self.host,
            "code": self.code,
            "stale": self.stale,
        }


def save(folder: Path, result: Result) -> Path:
    """Write a cell's result, whole or not at all, and return its path.

    Raises:
        OutputError: The folder cannot be written to, or the disk is full.
    """
    path = folder / CELLS / f"{result.cell.identity}.json"
    # No fsync: a file that a power failure leaves empty counts as missing and is run again.
    return write_whole(path, json.dumps(result.as_json()) + "\n", durable=False)


def load(folder: Path, cells: Sequence[Cell]) -> dict[str, Result]:
    """Return the results of these cells in a folder, by identity.

    Results of other code are marked stale; a file that cannot be read counts as missing.
    """
    results = {}
    for cell in cells:
        entries = read(folder, cell.identity)
        if entries is not None:
            results[cell.identity] = Result(
                cell=cell,
                status=entries["status"],
                row=entries["row"],
                error=entries["error"],
                seconds=entries["seconds"],
                host=entries["host"],
                code=entries["code"],
                stale=entries["stale"] or entries["code"] != cell.code,
            )
    return results


def read(folder: Path, identity: str) -> JSON | None:
    """Return the content of a cell's file, its row decoded; None if missing or damaged."""
    try:
        entries = json.loads(read_regular(folder / CELLS / f"{identity}.json", MAX_BYTES))
        _check(entries, identity)
        return {**entries, "row": decode_row(entries["row"])}
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return None


def _check(entries: Any, identity: str) -> None:
    """Raise ValueError where entries are not those of a cell's file."""
    error, seconds = entries["error"], entries["seconds"]
    row_or_error = error is None if entries["status"] == "done" else error is not None
    sound = (
        entries["schema"] == SCHEMA,
        entries["identity"] == identity == identity_of(entries["function"], entries["case"]),
        entries["status"] in get_args(Status) and row_or_error,
        error is None or isinstance(error["what"], str),
        type(seconds) in (int, float) and math.isfinite(seconds) and seconds >= 0.0,
        isinstance(entries["host"], str) and isinstance(entries["code"], str),
        isinstance(entries["stale"], bool),
    )
    if not all(sound):
        raise ValueError("not what a cell's file holds")


def count(folder: Path) -> int:
    """Return the number of results in a folder."""
    return sum(1 for _ in (folder / CELLS).glob("*.json"))


def clear(folder: Path) -> None:
    """Delete the results in a folder, and no other files.

    Raises:
        OutputError: They cannot be deleted, or `cells` is a symbolic link.
    """
    if (folder / CELLS).is_symlink():
        raise OutputError(
            "this is a link, and nothing is deleted behind one",
            where=str(folder / CELLS),
            fix="choose a new folder",
        )
    try:
        for path in (folder / CELLS).glob("*.json"):
            if read(folder, path.stem) is not None:
                path.unlink()
    except OSError as error:
        raise OutputError(
            f"cannot delete: {error.strerror or error}",
            where=str(folder / CELLS),
            fix="choose a folder that can be written to",
        ) from error
