"""Strict reading of a TOML table into a frozen dataclass."""

from __future__ import annotations

import dataclasses
import difflib
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from morph.errors import RobotError

Table = TypeVar("Table")


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where in a TOML file a table stands."""

    file: str
    """The file's path."""
    text: str
    """The file's text, to find the line of a key in."""
    section: str = ""
    """The table's header, such as `water` or `motor`; empty for the top."""
    index: int = 0
    """Which of the tables under this header, from 0."""

    def key(self, key: str) -> str:
        """Return the file and line of a key of this table, for an error."""
        lines = self.text.splitlines()
        name = re.escape(self.section)
        header = re.compile(rf"\s*\[\[?\s*{name}\s*\]\]?|\s*{name}\s*=")
        headers = [at for at, line in enumerate(lines) if self.section and header.match(line)]
        start = headers[min(self.index, len(headers) - 1)] if headers else 0
        wanted = re.compile(rf"(^|[\s,{{\[\"']){re.escape(key)}[\"']?\s*(=|\]|\.)")
        for at in range(start, len(lines)):
            if wanted.search(lines[at]):
                return f"{self.file}:{at + 1}"
        return f"{self.file}:{start + 1}"


def read_table(kind: type[Table], table: object, place: Place) -> Table:
    """Return a dataclass filled from a TOML table.

    A field's name is its key; a trailing underscore is dropped, for keys that
    Python reserves.

    Raises:
        RobotError: A key is unknown, missing, or holds a value of another type.
    """
    if not isinstance(table, Mapping):
        raise RobotError(
            f"{place.section} is {table!r}, not a table",
            where=place.key(place.section),
            fix=f"write it as a table with the keys {', '.join(_keys(kind))}",
        )
    keys = _keys(kind)
    for key in table:
        if key not in keys:
            raise _unknown(key, tuple(keys), place)
    hints = typing.get_type_hints(kind)
    values: dict[str, Any] = {}
    for key, field in keys.items():
        if key in table:
            values[field.name] = _value(hints[field.name], table[key], key, place)
        elif _required(field):
            raise RobotError(
                f"the key {key!r} is missing",
                where=place.key(place.section),
                fix=f"add {key} = ... to {place.section or 'the top of the file'}",
            )
    return kind(**values)


def _keys(kind: type[Any]) -> dict[str, dataclasses.Field[Any]]:
    return {field.name.rstrip("_"): field for field in dataclasses.fields(kind)}


def _required(field: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    return field.default is missing and field.default_factory is missing


def _unknown(key: str, known: tuple[str, ...], place: Place) -> RobotError:
    nearest = difflib.get_close_matches(key, known, n=1, cutoff=0.0)
    return RobotError(
        f"the key {key!r} is unknown; the nearest known one is {nearest[0]!r}",
        where=place.key(key),
        fix=f"use one of {', '.join(known)}",
    )


def _value(hint: Any, value: object, key: str, place: Place) -> Any:
    if typing.get_origin(hint) in (types.UnionType, typing.Union):
        hint = next(part for part in typing.get_args(hint) if part is not type(None))
    if typing.get_origin(hint) is tuple:
        return _values(typing.get_args(hint)[0], value, key, place)
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return read_table(hint, value, dataclasses.replace(place, section=key, index=0))
    if hint is float and type(value) in (int, float):
        return float(typing.cast(float, value))
    if type(value) is not hint:
        raise _mistyped(key, value, hint.__name__, place)
    return value


def _values(hint: Any, value: object, key: str, place: Place) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise _mistyped(key, value, "list", place)
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        places = (dataclasses.replace(place, section=key, index=at) for at in range(len(value)))
        return tuple(read_table(hint, item, at) for item, at in zip(value, places, strict=True))
    return tuple(_value(hint, item, key, place) for item in value)


def _mistyped(key: str, value: object, wanted: str, place: Place) -> RobotError:
    return RobotError(
        f"{key} is {value!r}, of type {type(value).__name__}, not {wanted}",
        where=place.key(key),
        fix=f"give {key} a value of type {wanted}",
    )
