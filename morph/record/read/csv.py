"""Reading CSV files, also gzipped: Arrow splits the text into cells."""

from __future__ import annotations

import csv
import io
import re
import string
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import compute
from pyarrow import csv as arrow

from morph.arrays import Integers
from morph.errors import RecordingError
from morph.record.limits import MOST_BREAKS, MOST_COLUMNS, MOST_LINE, most_unpacked, too_much
from morph.record.read.csv_cells import Cells
from morph.record.read.file import size_of
from morph.record.read.table import Table, listed, number
from morph.record.read.text import read_text
from morph.record.recording import Note

COLUMN_BYTES = 4096
"""Bytes of text that are split at once for each column, as each column costs time for itself."""
CELLS, ROWS = 2**19, 2**10
"""Cells that are cast at once, and rows if these hold more."""
Lines = Integers | range
"""Numbers of lines, from 1."""


def read_csv(path: Path) -> Table:
    """Return the columns of a `.csv` or `.csv.gz` file; lines of blank cells are passed over.

    The delimiter is the comma, semicolon or tab that the first line has most of.
    A first line of numbers alone is data: the columns then have no names.

    Raises:
        RecordingError: The file is missing, empty, truncated or not text, its lines differ in
            their number of fields, or it has more columns or numbers than are read.
    """
    text = read_text(path)
    ink = re.search(rb"[^\s,;]", text)
    if ink is None:
        raise RecordingError(
            "the file is empty", where=str(path), fix="record the episode again, or leave it out"
        )
    begin = text.rfind(b"\n", 0, ink.start()) + 1
    start = text[begin : text.index(b"\n", begin)]
    delimiter = max(",;\t", key=lambda each: start.count(each.encode()))
    header, end = _header(path, text, begin, delimiter)
    names = () if _all_numbers(header) else tuple(cell.strip() for cell in header)
    _check_names(path, names)
    _check_size(path, text, len(header))
    text, lines = _inked(text, begin, delimiter)
    at = bisect_right(lines, end) if names else 0
    columns, result = [Cells(len(lines)) for _ in header], []
    torn: list[Note] = []
    for batch, numbers in _rows(path, text, lines, delimiter, at, len(header), torn):
        for column, cells in zip(columns, batch.columns, strict=True):
            column.extend(cells)
        result.append(numbers)
    if not result:
        raise RecordingError(
            "the file has a header and no samples",
            where=f"{path}, line {lines[0]}",
            fix="record the episode again, or leave it out",
        )
    return Table(
        path=path,
        names=names,
        columns=tuple(column.column() for column in columns),
        lines=_joined(result),
        notes=tuple(torn),
    )


def _header(path: Path, text: bytes, begin: int, delimiter: str) -> tuple[list[str], int]:
    """Return the cells of the row that begins at a byte, and the number of the line it ends on."""
    lines = io.TextIOWrapper(io.BytesIO(text), encoding="utf-8", newline="\n")
    lines.seek(begin)
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
    try:
        header = next(reader)
    except csv.Error as error:
        raise _endless(path, 0) from error
    if len(header) > MOST_COLUMNS:
        raise RecordingError(
            f"the first line has {len(header)} fields; a file has {MOST_COLUMNS} columns at most",
            where=f"{path}, line 1",
            fix="write a line for each sample, or leave out the columns that nobody needs",
        )
    return header, text.count(b"\n", 0, begin) + reader.line_num


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


def _inked(text: bytes, begin: int, delimiter: str) -> tuple[bytes, Lines]:
    """Return the lines from a byte on that hold more than blanks, and their numbers."""
    blanks = string.whitespace + delimiter
    if not begin and not re.search(f"\n[{blanks}]".encode(), text):
        return text, range(1, text.count(b"\n") + 1)
    edges = np.flatnonzero(np.append(True, np.frombuffer(text, dtype=np.uint8) == ord("\n")))
    buffers = pa.py_buffer(edges), pa.py_buffer(text)
    lines = pa.LargeStringArray.from_buffers(len(edges) - 1, *buffers)
    inked = np.asarray(compute.not_equal(compute.ascii_trim(lines, blanks), ""))
    inked[: edges.searchsorted(begin)] = False
    return lines.filter(pa.array(inked)).buffers()[2].to_pybytes(), np.flatnonzero(inked) + 1


def _check_size(path: Path, text: bytes, width: int) -> None:
    lines = text.count(b"\n")
    # Lists hold a comma for each of their numbers but one.
    numbers = max(lines * width, lines + text.count(b","))
    most = most_unpacked(size_of(path))
    if numbers * 8 > most:
        raise too_much(
            f"the {numbers} numbers in {lines} lines of {width} columns take {numbers * 8} bytes, "
            f"of which {most} are read",
            str(path),
        )


def _rows(
    path: Path, text: bytes, lines: Lines, delimiter: str, at: int, width: int,
    torn: list[Note],
) -> Iterator[tuple[Any, Lines]]:  # fmt: skip
    """Give batches of rows, cells as texts or null, and the numbers of the lines they end on.

    A last line with too few cells, as a logger leaves it that was killed, is left out.

    Args:
        path: The file.
        text: Lines that each end in a newline.
        lines: Their numbers.
        delimiter: What separates cells.
        at: How many lines are before the first row.
        width: How many cells each row has.
        torn: Gets a note of a last line that is left out.

    Raises:
        RecordingError: A row has more or fewer cells, or one that does not end.
    """
    if at == len(lines):
        return
    quoted = b'"' in text
    if b' "' in text:
        # Arrow knows no spaces before a quote. Its `re` takes less memory than Python's.
        whole = pa.array([text], pa.large_binary())
        clean = compute.replace_substring_regex(whole, f'(^|{delimiter}|\n) +"', r'\1"')
        text = clean.buffers()[2].to_pybytes()
    numbers: Lines
    ragged: list[Any] = []

    def stop(row: Any) -> str:
        raw = b"\n" + row.text.encode() + b"\n"
        if row.actual_columns < width and text.find(raw) == len(text) - len(raw):
            torn.append(
                Note(
                    what=f"the last line has {row.actual_columns} of {width} fields and was left "
                    "out: the file seems to be truncated",
                    where=f"{path}, line {lines[-1]}",
                    dropped=1,
                )
            )
            return "skip"
        ragged.append(row)
        return "error"

    names = [str(column) for column in range(width)]
    block, step = MOST_LINE + COLUMN_BYTES * width, max(ROWS, CELLS // width)
    try:
        for batch in arrow.open_csv(
            # Without the last newline, which an open quote would take in.
            pa.BufferReader(memoryview(text)[:-1]),
            arrow.ReadOptions(
                use_threads=False, block_size=block, skip_rows=at, column_names=names
            ),
            arrow.ParseOptions(
                delimiter=delimiter,
                quote_char='"' if quoted else False,
                newlines_in_values=quoted,
                invalid_row_handler=stop,
            ),
            arrow.ConvertOptions(
                check_utf8=False,
                column_types=dict.fromkeys(names, pa.string()),
                null_values=[""],
                strings_can_be_null=True,
            ),
        ):
            if quoted:
                batch, numbers, at = _held(path, batch, lines, at)
            else:
                numbers, at = lines[at : at + batch.num_rows], at + batch.num_rows
            for row in range(0, batch.num_rows, step):
                yield batch.slice(row, step), numbers[row : row + step]
    except pa.ArrowInvalid as error:
        if ragged:
            raise _ragged(path, text, lines, ragged[0]) from error
        raise _endless(path, lines[at - 1] if at else 0) from error


def _held(path: Path, batch: Any, lines: Lines, at: int) -> tuple[Any, Lines, int]:
    """Return the rows that hold anything, their lines, and how many lines are behind all of them.

    Args:
        path: The file.
        batch: Rows, whose cells may hold newlines.
        lines: The numbers of all lines.
        at: How many of them are before these rows.

    Raises:
        RecordingError: A row takes more lines than one does whose quotes end.
    """
    cells, shape = pa.concat_arrays(batch.columns).fill_null(""), (batch.num_columns, -1)
    inked = compute.not_equal(compute.ascii_trim_whitespace(cells), "")
    held = np.reshape(inked, shape).any(axis=0)
    breaks = np.reshape(compute.count_substring(cells, "\n"), shape).sum(axis=0)
    ends = at + np.cumsum(1 + breaks)
    if held.all() and not breaks.any():
        return batch, lines[at : ends[-1]], int(ends[-1])
    numbers: Integers = ends if isinstance(lines, range) else lines[ends - 1]
    longest = int(breaks.argmax())
    if breaks[longest] > MOST_BREAKS:
        raise _endless(path, numbers[longest] - breaks[longest] - 1)
    return batch.filter(pa.array(held)), numbers[held], int(ends[-1])


def _joined(parts: list[Lines]) -> Lines:
    if all(isinstance(part, range) for part in parts):
        return range(parts[0][0], parts[-1][-1] + 1)
    return np.concatenate(parts)


def _ragged(path: Path, text: bytes, lines: Lines, row: Any) -> RecordingError:
    raw = row.text.encode()
    end = text.find(b"\n" + raw + b"\n") + 1 + len(raw)
    line = lines[text.count(b"\n", 0, end)]
    return RecordingError(
        f"the line has {row.actual_columns} fields, the first has {row.expected_columns}",
        where=f"{path}, line {line}",
        fix="copy the file again, or remove this line by hand",
    )


def _endless(path: Path, line: int) -> RecordingError:
    return RecordingError(
        "the text cannot be split into fields: one is too long, or its quotes do not end",
        where=f"{path}, behind line {line}",
        fix="correct the quotes",
    )
