"""Reading CSV files, also gzipped: a fast path for plain numbers, a careful one for the rest."""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.read.file import read_bytes
from morph.record.read.table import Column, Table, number

MOST_TEXT = 512 * 2**20
"""Most bytes of text, once unpacked."""

MOST_LINES = 5_000_000
"""Most lines: an hour at 1 kHz has 3.6 million."""


def read_csv(path: Path) -> Table:
    """Return the columns of a `.csv` or `.csv.gz` file.

    The delimiter is the comma, semicolon or tab that the first line has most of.
    A first line of numbers alone is data: the columns then have no names.

    Raises:
        RecordingError: The file is missing, empty, truncated or not text, or its
            lines differ in their number of fields.
    """
    text = _text(path)
    lines = text.split("\n")
    while lines and not lines[-1].strip():
        lines.pop()
    if not lines:
        raise RecordingError(
            "the file is empty", where=str(path), fix="record the episode again, or leave it out"
        )
    delimiter = max(",;\t", key=lines[0].count)
    header = _rows(path, lines[:1], delimiter)[0][1]
    names = () if _all_numbers(header) else tuple(cell.strip() for cell in header)
    _check_names(path, names)
    first = 1 if names else 0
    if len(lines) == first:
        raise RecordingError(
            "the file has a header and no samples",
            where=f"{path}, line 1",
            fix="record the episode again, or leave it out",
        )
    plain = _plain(lines, first, len(header), delimiter)
    if plain is not None:
        numbers = np.arange(first + 1, len(lines) + 1, dtype=np.int64)
        return Table(path=path, names=names, columns=tuple(plain.T), lines=numbers)
    rows = _rows(path, lines, delimiter)[first:]
    if not rows:
        raise RecordingError(
            "the file has a header and not one sample",
            where=str(path),
            fix="record the episode again, or leave it out",
        )
    return _careful(path, names, rows, len(header))


def _text(path: Path) -> str:
    data = read_bytes(path)
    try:
        if data[:2] == b"\x1f\x8b" or path.suffix == ".gz":
            with gzip.open(io.BytesIO(data)) as packed:
                data = packed.read(MOST_TEXT + 1)
        _check_size(path, len(data), data.count(b"\n"))
        text = data.decode("utf-8-sig")
    except (EOFError, OSError, zlib.error) as error:
        raise RecordingError(
            f"the compressed file is truncated or damaged: {error}",
            where=str(path),
            fix="copy the file again; what is left of it is not read",
        ) from error
    except UnicodeDecodeError as error:
        raise RecordingError(
            f"the file is not text: byte {error.start} is {error.object[error.start]:#04x}",
            where=str(path),
            fix="give a CSV file in UTF-8, or name the file by what it holds",
        ) from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _check_size(path: Path, size: int, lines: int) -> None:
    if size > MOST_TEXT or lines > MOST_LINES:
        raise RecordingError(
            f"the text has more than {MOST_TEXT} bytes or {MOST_LINES} lines",
            where=str(path),
            fix="cut the recording into episodes, or save it as Parquet",
        )


def _plain(lines: list[str], first: int, width: int, delimiter: str) -> Array | None:
    """Return the numbers, shape (rows, columns), or None if a line is anything else."""
    try:
        data: Array = np.loadtxt(
            lines, delimiter=delimiter, skiprows=first, comments=None, ndmin=2, quotechar='"'
        )
    except ValueError:
        return None
    return data if data.shape == (len(lines) - first, width) else None


def _rows(path: Path, lines: Sequence[str], delimiter: str) -> list[tuple[int, list[str]]]:
    """Return the fields of each line that is not blank, with its number from 1."""
    source = io.StringIO("\n".join(lines), newline="\n")
    reader = csv.reader(source, delimiter=delimiter, skipinitialspace=True)
    rows = []
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                rows.append((reader.line_num, row))
    except csv.Error as error:
        raise RecordingError(
            f"the line cannot be split into fields: {error}",
            where=f"{path}, line {reader.line_num}",
            fix="correct the quotes on this line",
        ) from error
    return rows or [(1, list(lines[:1]))]


def _careful(
    path: Path, names: tuple[str, ...], rows: list[tuple[int, list[str]]], width: int
) -> Table:
    for at, (line, row) in enumerate(rows):
        if len(row) != width:
            last = at == len(rows) - 1
            raise RecordingError(
                f"the {'last ' if last else ''}line has {len(row)} fields, the first has {width}"
                + ("; the file seems to be truncated" if last else ""),
                where=f"{path}, line {line}",
                fix="copy the file again, or remove this line by hand",
            )
    cells = zip(*(row for _, row in rows), strict=True)
    return Table(
        path=path,
        names=names,
        columns=tuple(_column(column) for column in cells),
        lines=np.array([line for line, _ in rows], dtype=np.int64),
    )


def _column(cells: tuple[str, ...]) -> Column:
    lists = all(cell.startswith("[") and cell.rstrip().endswith("]") for cell in cells)
    try:
        if not lists:
            return np.array([number(cell) for cell in cells])
        inner = [cell.strip()[1:-1] for cell in cells]
        data: Array = np.loadtxt(inner, delimiter=",", comments=None, ndmin=2)
    except ValueError:
        return cells
    return data if len(data) == len(cells) else cells


def _all_numbers(cells: list[str]) -> bool:
    try:
        return bool(np.isfinite([number(cell) for cell in cells]).any())
    except ValueError:
        return False


def _check_names(path: Path, names: tuple[str, ...]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise RecordingError(
            f"the header names a column twice: {', '.join(map(repr, twice))}",
            where=f"{path}, line 1",
            fix="rename one of the two columns",
        )
