"""The cells of a CSV column as numbers, cast by Arrow; where it fails, `number` decides."""

from __future__ import annotations

from array import array
from contextlib import suppress
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import compute

from morph.arrays import Array
from morph.record.read.table import Column, Text, number


class Cells:
    """The cells of one column, up to the first that is no number."""

    def __init__(self, rows: int) -> None:
        """Start a column of so many rows at most; what they do not fill takes no memory."""
        self._values = np.empty(rows)
        self._filled = 0
        self._elements = 0
        """Numbers in each cell if cells hold lists; 0 if each is a number."""
        self._text: Text | None = None

    def extend(self, cells: Any) -> None:
        """Take in the next cells: texts, or null."""
        if self._text is not None:
            return
        if not self._filled:
            first = (cells[0].as_py() or "").strip()
            self._elements = first.count(",") + 1 if first.startswith("[") else 0
        each = max(1, self._elements)
        # An element of a list is never missing.
        blank = "none" if self._elements else ""
        numbers = _numbers(_parts(cells, each) if self._elements else cells, blank)
        end = self._filled + len(numbers)
        if len(numbers) < each * len(cells):
            cell = (cells[len(numbers) // each].as_py() or "").strip()[:60]
            self._text, self._values = Text(cell=cell, row=end // each), np.empty(0)
            return
        if end > len(self._values):
            self._values = np.concatenate([self._values[: self._filled], np.empty(end)])
        self._values[self._filled : end] = numbers
        self._filled = end

    def column(self) -> Column:
        """Return the numbers, the lists of numbers, or that it is text."""
        if self._text is not None:
            return self._text
        values = self._values[: self._filled]
        return values.reshape(-1, self._elements) if self._elements else values


def _parts(cells: Any, elements: int) -> Any:
    """Return what stands in lists, up to the first cell that is no list with so many elements."""
    cells = compute.ascii_trim_whitespace(cells)
    lists = compute.split_pattern(compute.utf8_slice_codeunits(cells, 1, -1), ",")
    good = compute.equal(compute.list_value_length(lists), elements)
    for bracket in (compute.starts_with(cells, "["), compute.ends_with(cells, "]")):
        good = compute.and_(good, bracket)
    bad = compute.index(good.fill_null(False), False).as_py()
    return (lists if bad < 0 else lists[:bad]).flatten()


def _numbers(cells: Any, blank: str) -> Array:
    """Return the numbers of cells up to the first that is none; a blank one counts as `blank`."""
    cells = compute.ascii_trim_whitespace(cells)
    # A cast that fails takes its time; text mostly shows in the first cell, or in the last.
    if len(_one_by_one(pa.concat_arrays([cells[:1], cells[-1:]]), blank)) < 2:
        return _one_by_one(cells, blank)
    with suppress(pa.ArrowInvalid):
        numbers: Array = cells.cast("float64").to_numpy(zero_copy_only=False)
        # For Arrow `nan(1)` is a number.
        odd = np.isnan(numbers).any() and compute.any(compute.match_substring(cells, "(")).as_py()
        if not odd:
            return numbers
    return _one_by_one(cells, blank)


def _one_by_one(cells: Any, blank: str) -> Array:
    numbers = array("d")
    texts = (cell if cell and cell.strip() else blank for cell in cells.to_pylist())
    with suppress(ValueError):
        numbers.extend(map(number, texts))
    return np.asarray(numbers)
