"""Reading structures in Thrift's compact protocol, as Parquet files hold them.

Source: thrift-compact-protocol.md of https://github.com/apache/thrift.
"""

from __future__ import annotations

from typing import Any

TRUE, FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, STRUCT = *range(1, 11), 12
"""Kinds of fields; Parquet has no maps, which are 11."""

WIDTH = {BYTE: 1, DOUBLE: 8}
"""Bytes of the kinds whose values are passed over."""

DEEPEST = 16
"""Deepest nesting that is read; Parquet's own is 7."""

EMPTY: dict[int, Any] = {}
"""Of all structures without fields, of which a byte would hold one."""


class Struct:
    """Reads one structure from its first byte on.

    Args:
        data: Bytes that begin with it.
    """

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def fields(self) -> dict[int, Any]:
        """Return the fields by their numbers: integers, lists and structures; all else is None.

        Raises:
            ValueError: It breaks off, nests too deeply, or is of another format.
        """
        try:
            return self._struct(0)
        except IndexError as error:
            raise ValueError("a structure breaks off") from error

    def _struct(self, depth: int) -> dict[int, Any]:
        if depth > DEEPEST:
            raise ValueError("a structure nests too deeply")
        fields: dict[int, Any] = {}
        number = 0
        while (head := self._byte()) != 0:
            step = head >> 4
            number = number + step if step else self._signed()
            kind = head & 15
            # A field that is a boolean has its value in its kind.
            fields[number] = None if kind in (TRUE, FALSE) else self._value(kind, depth)
        return fields or EMPTY

    def _value(self, kind: int, depth: int) -> Any:
        if kind in (I16, I32, I64):
            return self._signed()
        if kind == STRUCT:
            return self._struct(depth + 1)
        if kind in (LIST, SET):
            head = self._byte()
            length = head >> 4 if head >> 4 < 15 else self._unsigned()
            # An element takes a byte or more.
            if length > len(self.data) - self.at:
                raise ValueError("a list is longer than what holds it")
            return [self._value(head & 15, depth + 1) for _ in range(length)]
        if kind in (TRUE, FALSE, BYTE, DOUBLE, BINARY):
            length = self._unsigned() if kind == BINARY else WIDTH.get(kind, 1)
            self.at += length
            return None
        raise ValueError(f"a structure has a field of kind {kind}")

    def _byte(self) -> int:
        self.at += 1
        return self.data[self.at - 1]

    def _unsigned(self) -> int:
        value = shift = 0
        while shift < 70:
            byte = self._byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value
            shift += 7
        raise ValueError("a structure has a number of more than 64 bits")

    def _signed(self) -> int:
        value = self._unsigned()
        return (value >> 1) ^ -(value & 1)
