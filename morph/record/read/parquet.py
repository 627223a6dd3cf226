"""Reading Parquet files."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.read.file import read_bytes
from morph.record.read.table import Column, Table


def read_parquet(path: Path) -> Table:
    """Return the columns of a Parquet file; a null is NaN.

    Raises:
        RecordingError: The file is missing, empty or damaged.
    """
    from pyarrow import parquet

    data = read_bytes(path)
    try:
        table = parquet.read_table(io.BytesIO(data))
        names = tuple(str(name) for name in table.column_names)
        columns = tuple(_column(table.column(at)) for at in range(len(names)))
    # Arrow's errors derive from several built-in ones, by the kind of damage.
    except Exception as error:
        raise RecordingError(
            f"the file is truncated, damaged or not Parquet: {str(error)[:200]}",
            where=str(path),
            fix="copy the file again, or write it again",
        ) from error
    if not columns or len(columns[0]) == 0:
        raise RecordingError(
            "the file has no samples",
            where=str(path),
            fix="record the episode again, or leave it out",
        )
    return Table(path=path, names=names, columns=columns)


def _column(column: Any) -> Column:
    """Return numbers, lists of equal length as rows, or the cells' texts."""
    from pyarrow import types

    kind = column.type
    if types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind):
        values: Array = column.cast("float64", safe=False).to_numpy().astype(np.float64)
        return values
    cells = column.to_pylist()
    if all(isinstance(cell, list) for cell in cells) and len({len(cell) for cell in cells}) == 1:
        try:
            return np.array(cells, dtype=np.float64)
        except (TypeError, ValueError):
            pass
    return tuple(str(cell) for cell in cells)
