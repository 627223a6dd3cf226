"""Reading CSV files, also gzipped: a fast path for plain numbers, a careful one for the rest."""

from __future__ import annotations

import csv
import io
from array import array
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.limits import MOST_COLUMNS, most_unpacked, too_much
from morph.record.read.file import size_of
from morph.record.read.table import Column, Table, Text, listed, number
from morph.record.read.text import read_text

BLOCK = 100_000
"""Cells that are held as texts at once; each takes ten times what its number does."""

Row = tuple[int, list[str]]
"""The number of a line, from 1, and its fields."""


def read_csv(path: Path) -> Table:
    """Return the columns of a `.csv` or `.csv.gz` file.

    The delimiter is the comma, semicolon or tab that the first line has most of.
    A first line of numbers alone is data: the columns then have no names.

    Raises:
        RecordingError: The file is missing, empty, truncated or not text, its lines differ in
            their number of fields, or it has more columns or numbers than are read.
    """
    text = read_text(path)
    if not text or text.isspace():
        raise RecordingError(
            "the file is empty", where=str(path), fix="record the episode again, or leave it out"
        )
    start = text[: text.find(b"\n")] if b"\n" in text else text
    delimiter = max(",;\t", key=lambda each: start.count(each.encode()))
    _check_width(path, start.count(delimiter.encode()) + 1)
    header = next(_rows(path, start, delimiter), (1, [start.decode()]))[1]
    names = () if _all_numbers(header) else tuple(cell.strip() for cell in header)
    _check_names(path, names)
    first = 1 if names else 0
    lines = text.count(b"\n") + 1
    if lines == first:
        raise RecordingError(
            "the file has a header and no samples",
            where=f"{path}, line 1",
            fix="record the episode again, or leave it out",
        )
    needed, most = lines * len(header) * 8, most_unpacked(size_of(path))
    if needed > most:
        raise too_much(
            f"{lines} lines of {len(header)} columns take {needed} bytes, of which {most} are read",
            str(path),
        )
    plain = _plain(text, first, lines, len(header), delimiter)
    if plain is not None:
        numbers = np.arange(first + 1, lines + 1, dtype=np.int64)
        return Table(path=path, names=names, columns=tuple(plain.T), lines=numbers)
    return _careful(path, names, islice(_rows(path, text, delimiter), first, None), len(header))


def _check_width(path: Path, width: int) -> None:
    if width > MOST_COLUMNS:
        raise RecordingError(
            f"the first line has {width} fields; a file has {MOST_COLUMNS} columns at most",
            where=f"{path}, line 1",
            fix="write a line for each sample, or leave out the columns that nobody needs",
        )


def _plain(text: bytes, first: int, lines: int, width: int, delimiter: str) -> Array | None:
    """Return the numbers, shape (rows, columns), or None if a line is anything else."""
    try:
        data: Array = np.loadtxt(
            _stream(text), delimiter=delimiter, skiprows=first, comments=None, ndmin=2,
            quotechar='"',
        )  # fmt: skip
    except ValueError:
        return None
    return data if data.shape == (lines - first, width) else None


def _stream(text: bytes) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(text), encoding="utf-8", newline="\n")


def _rows(path: Path, text: bytes, delimiter: str) -> Iterator[Row]:
    """Give the fields of each line that is not blank, with its number from 1.

    Raises:
        RecordingError: A line cannot be split.
    """
    reader = csv.reader(_stream(text), delimiter=delimiter, skipinitialspace=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                yield reader.line_num, row
    except csv.Error as error:
        raise RecordingError(
            f"the line cannot be split into fields: {error}",
            where=f"{path}, line {reader.line_num}",
            fix="correct the quotes on this line",
        ) from error


def _careful(path: Path, names: tuple[str, ...], rows: Iterator[Row], width: int) -> Table:
    cells = [_Cells() for _ in range(width)]
    lines = array("q")
    while block := list(islice(rows, max(2, BLOCK // width))):
        for line, row in block:
            if len(row) != width:
                last = (line, row) == block[-1] and next(rows, None) is None
                raise _ragged(path, line, len(row), width, last)
        lines.extend(line for line, _ in block)
        for column, texts in zip(cells, zip(*(row for _, row in block), strict=True), strict=True):
            column.extend(texts)
    if not lines:
        raise RecordingError(
            "the file has a header and not one sample",
            where=str(path),
            fix="record the episode again, or leave it out",
        )
    columns = tuple(column.column() for column in cells)
    return Table(
        path=path, names=names, columns=columns, lines=np.frombuffer(lines, dtype=np.int64)
    )


def _ragged(path: Path, line: int, fields: int, width: int, last: bool) -> RecordingError:
    return RecordingError(
        f"the {'last ' if last else ''}line has {fields} fields, the first has {width}"
        + ("; the file seems to be truncated" if last else ""),
        where=f"{path}, line {line}",
        fix="copy the file again, or remove this line by hand",
    )


class _Cells:
    """The cells of one column as numbers, up to the first that is none."""

    def __init__(self) -> None:
        self.values = array("d")
        self.rows = 0
        self.width = 0
        """Numbers in each cell; 0 until there is one."""
        self.lists = False
        self.text: Text | None = None

    def extend(self, cells: tuple[str, ...]) -> None:
        """Take in the next cells."""
        if self.text is not None:
            return
        if self.rows == 0:
            self.lists = _is_list(cells[0])
        try:
            if self.lists:
                for cell in cells:
                    self._list(cell)
            else:
                self.values.extend([number(cell) for cell in cells])
        except ValueError:
            at = 0 if self.lists else next(at for at, cell in enumerate(cells) if _is_text(cell))
            self.text = Text(cell=cells[at][:60], row=self.rows + at)
            self.values = array("d")
        self.rows += len(cells)

    def column(self) -> Column:
        """Return the numbers, the lists of numbers, or that it is text."""
        if self.text is not None:
            return self.text
        values = np.frombuffer(self.values, dtype=np.float64)
        return values.reshape(self.rows, -1) if self.lists else values

    def _list(self, cell: str) -> None:
        if not _is_list(cell):
            raise ValueError(cell)
        parts = cell.strip()[1:-1].split(",")
        if not all(map(str.strip, parts)) or self.width not in (0, len(parts)):
            raise ValueError(cell)
        self.width = len(parts)
        self.values.extend([number(part) for part in parts])


def _is_list(cell: str) -> bool:
    return cell.startswith("[") and cell.rstrip().endswith("]")


def _is_text(cell: str) -> bool:
    try:
        number(cell)
    except ValueError:
        return True
    return False


def _all_numbers(cells: list[str]) -> bool:
    try:
        return bool(np.isfinite([number(cell) for cell in cells]).any())
    except ValueError:
        return False


def _check_names(path: Path, names: tuple[str, ...]) -> None:
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise RecordingError(
            f"the header names a column twice: {listed(map(repr, twice))}",
            where=f"{path}, line 1",
            fix="rename one of the two columns",
        )
