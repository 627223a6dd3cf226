"""A file's columns as they stand in it, with the line of each row for errors."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from morph.arrays import Array, Integers
from morph.errors import RecordingError
from morph.nearest import nearest
from morph.record.recording import Note


@dataclass(frozen=True, kw_only=True)
class Text:
    """A column that is not all numbers."""

    cell: str
    """The first cell that is no number; its first 60 letters."""
    row: int
    """In which row it is, from 0."""


Column = Array | Text
"""Numbers of shape (rows,), lists of shape (rows, elements), or text."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """What a file holds, before units and names are given to it."""

    path: Path
    """The file."""
    names: tuple[str, ...]
    """The columns' names, in order; empty if the file has no header."""
    columns: tuple[Column, ...]
    """The columns, in order; those of an NPZ may differ in length."""
    lines: Integers | range | None = None
    """The line, or the topic's message, of each row, from 1; None where a file has neither."""
    topic: str = ""
    """The topic of a bag that the rows are messages of; empty for any other file."""
    clock: Array | None = None
    """When each row was taken, s; None where a column, or nothing, says so."""
    notes: tuple[Note, ...] = ()
    """What was not read, and which clock was taken."""

    def place(self, *rows: int) -> str:
        """Return the file and the lines, or samples, of some rows, for a message."""
        numbers = [int(self.lines[row]) if self.lines is not None else row for row in rows]
        word = "sample" if self.lines is None else "message" if self.topic else "line"
        shown = ", ".join(str(number) for number in numbers[:5])
        more = f" and {len(numbers) - 5} more" if len(numbers) > 5 else ""
        topic = f"topic {self.topic}, " if self.topic else ""
        return f"{self.path}, {topic}{word}{'s' if len(numbers) > 1 else ''} {shown}{more}"

    def column(self, which: str | int, element: int | None = None) -> Array:
        """Return a column's numbers, shape (rows,); a missing cell is NaN.

        Args:
            which: Its name, or its number from 0.
            element: Which element of a cell that holds a list, from 0.

        Raises:
            RecordingError: There is no such column or element, or a cell is no number.
        """
        index = self._index(which)
        column = self.columns[index]
        if isinstance(column, Text):
            raise self._not_numbers(which, column)
        if element is None:
            if column.ndim == 1:
                return column
            raise RecordingError(
                f"each cell of column {which!r} holds {column.shape[1]} numbers",
                where=str(self.path),
                fix=f"add element = 0 ... {column.shape[1] - 1} to say which one",
            )
        if column.ndim == 1 or not 0 <= element < column.shape[1]:
            held = "one number" if column.ndim == 1 else f"{column.shape[1]} numbers"
            raise RecordingError(
                f"column {which!r} has no element {element}: each cell holds {held}",
                where=str(self.path),
                fix="leave element out, or count from 0 within the cell",
            )
        return column[:, element]

    def _index(self, which: str | int) -> int:
        if isinstance(which, str) and which in self.names:
            return self.names.index(which)
        if isinstance(which, int) and 0 <= which < len(self.columns):
            return which
        known = listed(self.names) if self.names else "no names, only numbers"
        near = nearest(str(which), self.names) if self.names else "its number"
        raise RecordingError(
            f"there is no column {which!r}; the file has {len(self.columns)} columns: {known}",
            where=str(self.path),
            fix=f"name a column that is there; the nearest are {near}",
        )

    def _not_numbers(self, which: str | int, text: Text) -> RecordingError:
        european = re.fullmatch(r"[+-]?\d+,\d+([eE][+-]?\d+)?", text.cell.strip())
        return RecordingError(
            f"the cell {text.cell!r} in column {which!r} is not a number",
            where=self.place(text.row),
            fix="write decimals with a point, as 0.5, instead of a comma"
            if european
            else "correct the cell, leave it empty if the sample is missing, "
            "or bind another column; cells that hold lists must all be equally long",
        )


def listed(names: Iterable[str], *, most: int = 30) -> str:
    """Return names for a message, the first of them if they are many."""
    names = tuple(names)
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def number(cell: str) -> float:
    """Return a cell's number; an empty cell is NaN, a sample that is missing.

    Raises:
        ValueError: It is not a number as loggers write them.
    """
    if "_" in cell:
        raise ValueError(cell)
    return float(cell) if cell.strip() else float("nan")
