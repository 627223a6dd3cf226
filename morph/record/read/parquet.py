"""Reading Parquet files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.limits import MOST_COLUMNS, most_unpacked, too_much
from morph.record.read.file import opened
from morph.record.read.pages import Declared, declared
from morph.record.read.table import Column, Table, Text


def read_parquet(path: Path) -> Table:
    """Return the columns of a Parquet file; a null is NaN.

    Raises:
        RecordingError: The file is missing, empty or damaged, or declares more columns or
            numbers than are read.
    """
    with opened(path) as file:
        try:
            names, columns = _columns(file, path)
        except RecordingError:
            raise
        # Arrow's errors derive from several built-in ones, by the kind of damage.
        except Exception as error:
            raise RecordingError(
                f"the file is truncated, damaged or not Parquet: {str(error)[:200]}",
                where=str(path),
                fix="copy the file again, or write it again",
            ) from error
    return Table(path=path, names=names, columns=columns)


def _columns(file: BinaryIO, path: Path) -> tuple[tuple[str, ...], tuple[Column, ...]]:
    from pyarrow import parquet

    _check(declared(file), most_unpacked(os.fstat(file.fileno()).st_size), path)
    file.seek(0)
    with parquet.ParquetFile(file) as source:
        columns, leaf = [], 0
        # One after the other, so that Arrow's copy of one column alone stands beside ours.
        for field in source.schema_arrow:
            if _is_number(field.type) or _holds_numbers(field.type):
                columns.append(_column(source.reader.read_all(column_indices=[leaf]).column(0)))
            else:
                columns.append(Text(cell=f"<{str(field.type)[:40]}>", row=0))
            leaf += _leaves(field.type)
        return tuple(source.schema_arrow.names), tuple(columns)


def _check(result: Declared, most: int, path: Path) -> None:
    """Refuse a file without samples, and one that takes more memory than was allowed."""
    if result.rows == 0 or result.columns == 0:
        raise RecordingError(
            "the file has no samples",
            where=str(path),
            fix="record the episode again, or leave it out",
        )
    if result.columns > MOST_COLUMNS:
        raise RecordingError(
            f"the file has {result.columns} columns; {MOST_COLUMNS} are read at most",
            where=str(path),
            fix="leave out the columns that nobody needs",
        )
    if result.memory > most:
        raise too_much(
            f"{result.rows} rows of {result.columns} columns take {result.memory} bytes, of which "
            f"{most} are read",
            str(path),
        )


def _is_number(kind: Any) -> bool:
    from pyarrow import types

    return bool(types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind))


def _holds_numbers(kind: Any) -> bool:
    from pyarrow import types

    lists = types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind)
    return bool(lists and _is_number(kind.value_type))


def _leaves(kind: Any) -> int:
    """Return how many columns of the file a field is made of."""
    inner = [kind.field(at).type for at in range(kind.num_fields)]
    return sum(map(_leaves, inner)) if inner else 1


def _column(column: Any) -> Column:
    """Return numbers, or lists of equal length as rows."""
    from pyarrow import compute

    if _is_number(column.type):
        return _floats(column)
    lengths = compute.list_value_length(column)
    least, most = compute.min_max(lengths).values()
    if column.null_count or least != most:
        return Text(cell="<lists that differ in length>", row=0)
    return _floats(compute.list_flatten(column)).reshape(len(column), -1)


def _floats(column: Any) -> Array:
    values: Array = column.cast("float64", safe=False).to_numpy().astype(np.float64, copy=False)
    return values
