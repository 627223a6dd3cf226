"""What a Parquet file declares in its footer and its pages, read before Arrow believes it.

Source: parquet.thrift of https://github.com/apache/parquet-format.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, BinaryIO

from morph.record.limits import MOST_CHUNK, MOST_FOOTER, MOST_PAGES
from morph.record.read.thrift import Struct

MAGIC = b"PAR1"
"""How a file begins and ends."""

LONGEST_HEADER = 1 << 16
"""Longest header of a page that is looked at; statistics of texts take a few hundred bytes."""

ROWS, GROUPS, COLUMNS, ABOUT = 3, 4, 1, 3
"""Fields: of the footer its rows and groups, of a group its columns, of a column its metadata."""

VALUES, UNPACKED, PACKED, DATA, DICTIONARY = 5, 6, 7, 9, 11
"""Fields of a column's metadata: how many values, their bytes, and where its pages begin."""

PAGE_UNPACKED, PAGE_PACKED, PAGE_KINDS = 2, 3, (5, 7, 8)
"""Fields of a page's header: its bytes, and what it holds, by kind."""

PAGE_VALUES = 1
"""The field of every kind of page with its number of values."""


@dataclass(frozen=True, kw_only=True)
class Declared:
    """How much a file says that it holds."""

    rows: int
    """Its rows."""
    columns: int
    """Its columns."""
    memory: int
    """Bytes of its values, 8 each, or of its pages, unpacked, whichever is more."""


def declared(file: BinaryIO) -> Declared:
    """Return how much a file says that it holds, in its footer or in its pages.

    Raises:
        ValueError: It is damaged, no Parquet, or declares pages, or as many, as no file has.
    """
    footer = _footer(file)
    rows = _number(footer, ROWS)
    chunks: list[dict[int, Any]] = []
    columns = 0
    for group in _list(footer, GROUPS):
        inside = _list(group, COLUMNS)
        columns = max(columns, len(inside))
        chunks += (_struct(each, ABOUT) for each in inside)
    pages = _Pages(file)
    for chunk in chunks:
        start = _number(chunk, DATA)
        if chunk.get(DICTIONARY):
            start = min(start, _number(chunk, DICTIONARY))
        pages.add(start, _number(chunk, PACKED))
    values = max(rows * columns, sum(_number(chunk, VALUES) for chunk in chunks), pages.values)
    unpacked = max(sum(_number(chunk, UNPACKED) for chunk in chunks), pages.unpacked)
    return Declared(rows=rows, columns=columns, memory=max(8 * values, unpacked))


def _footer(file: BinaryIO) -> dict[int, Any]:
    size = os.fstat(file.fileno()).st_size
    file.seek(max(0, size - 8))
    tail = file.read(8)
    length = int.from_bytes(tail[:4], "little")
    if tail[4:] != MAGIC or length > min(size - 8, MOST_FOOTER):
        raise ValueError(f"its footer of {length} bytes in {size} cannot be")
    file.seek(size - 8 - length)
    return Struct(file.read(length)).fields()


class _Pages:
    """Adds up what pages declare."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.count = self.unpacked = self.values = 0

    def add(self, start: int, length: int) -> None:
        """Take in the pages of one column in one group of rows."""
        at, end = start, start + length
        while at < end:
            self.file.seek(at)
            header = Struct(self.file.read(min(LONGEST_HEADER, end - at)))
            fields = header.fields()
            unpacked, packed = _number(fields, PAGE_UNPACKED), _number(fields, PAGE_PACKED)
            kinds = [_struct(fields, each) for each in PAGE_KINDS if each in fields]
            self.values += sum(_number(each, PAGE_VALUES) for each in kinds)
            self.unpacked += unpacked
            self.count += 1
            if unpacked > MOST_CHUNK or self.count > MOST_PAGES:
                raise ValueError(f"page {self.count} declares {unpacked} bytes")
            at += header.at + packed
        if at != end:
            raise ValueError("its pages do not end where their column does")


def _number(fields: dict[int, Any], which: int) -> int:
    value = fields.get(which)
    if not isinstance(value, int) or value < 0:
        raise ValueError(f"field {which} is {value}")
    return value


def _struct(fields: object, which: int) -> dict[int, Any]:
    value = fields.get(which) if isinstance(fields, dict) else None
    if not isinstance(value, dict):
        raise ValueError(f"field {which} is no structure")
    return value


def _list(fields: object, which: int) -> list[Any]:
    value = fields.get(which) if isinstance(fields, dict) else None
    if not isinstance(value, list):
        raise ValueError(f"field {which} is no list")
    return value
