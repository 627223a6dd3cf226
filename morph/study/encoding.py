"""Encoding of cases and rows as JSON, and back without loss."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Mapping
from pkgutil import resolve_name
from typing import Any

from morph.arrays import JSON
from morph.errors import StudyError

TAG = "!"
"""First letter of the keys that mark types which JSON lacks: tuples, dataclasses, nan."""

MAX_DEPTH = 32
"""Levels of nesting; a list that contains itself would have no end."""


MAX_BITS = 13_000
"""Largest integer: of some 3,900 digits, as Python writes and reads none of more than 4,300."""


def encode_case(case: Any) -> JSON:
    """Return a case as JSON from which `decode_case` makes an equal one.

    Args:
        case: A mapping from strings to plain values, or a frozen dataclass of plain values:
            numbers, strings, None, and lists, tuples, mappings and frozen dataclasses of these.

    Raises:
        StudyError: It holds another type, or a number that is not finite.
    """
    if not isinstance(case, Mapping) and not _is_dataclass(case):
        raise _unencodable(case, "case", "a case is a mapping or a frozen dataclass")
    encoded: JSON = _encode(case, "case", row=False)
    return encoded


def encode_row(row: Any) -> Any:
    """Return a row as JSON: tuples become lists, dataclasses mappings.

    Numbers that are not finite are kept as `{"!float": "nan"}`, for `decode_row`.

    Raises:
        StudyError: It holds another type, or is nested too deeply.
    """
    return _encode(row, "row", row=True)


def decode_case(encoded: JSON) -> Any:
    """Return the case that `encode_case` was given.

    Raises:
        StudyError: It names a class that is not a dataclass here.
        ImportError: The module of a class cannot be imported.
        AttributeError: The module has no such class.
    """
    return _decode(encoded)


def decode_row(encoded: Any) -> Any:
    """Return a row with its infinite numbers and nan restored; dataclasses stay mappings."""
    if isinstance(encoded, list):
        return [decode_row(each) for each in encoded]
    if isinstance(encoded, dict):
        if encoded.keys() == {"!float"}:
            return float(encoded["!float"])
        return {key: decode_row(each) for key, each in encoded.items()}
    return encoded


def modules_of(encoded: Any) -> set[str]:
    """Return the modules of the dataclasses in an encoded case."""
    if isinstance(encoded, list):
        return {name for each in encoded for name in modules_of(each)}
    if isinstance(encoded, dict):
        kind = encoded.get("!dataclass")
        own = {kind.partition(":")[0]} if isinstance(kind, str) else set()
        return own | {name for each in encoded.values() for name in modules_of(each)}
    return set()


def importable(thing: Any, kind: str) -> str:
    """Return the name `module:name` by which another process finds a function or a class.

    What `python -m module` defines is found under that module's name.

    Raises:
        StudyError: It is a lambda, stands inside a function, or was typed at a prompt.
    """
    module, name = thing.__module__, thing.__qualname__
    if not name.isidentifier():
        raise StudyError(
            f"{kind} {name!r} of {module} cannot be found by another process",
            where="morph.study",
            fix="define it at the top level of a module, with `def` or `class`",
        )
    if module == "__main__":
        spec = getattr(sys.modules["__main__"], "__spec__", None)
        if spec is None:
            raise StudyError(
                f"{kind} {name!r} stands in the program itself, which no other process can import",
                where="morph.study",
                fix="move it into a module, or run the program by `python -m MODULE`",
            )
        module = spec.name
    return f"{module}:{name}"


def _is_dataclass(value: Any) -> bool:
    return dataclasses.is_dataclass(value) and not isinstance(value, type)


def _unencodable(value: Any, at: str, why: str) -> StudyError:
    return StudyError(
        f"{at} is a {type(value).__name__}: {why}",
        where="morph.study",
        fix="use Python numbers, strings, None, and lists, tuples, mappings and frozen dataclasses "
        "of these; NumPy's numbers and arrays by .tolist()",
    )


def _encode(value: Any, at: str, *, row: bool, depth: int = 0) -> Any:
    if depth > MAX_DEPTH:
        raise _unencodable(value, at[:80], f"more than {MAX_DEPTH} values inside each other")
    if type(value) is int and value.bit_length() > MAX_BITS:
        raise _unencodable(value, at, f"{value.bit_length()} bits, and {MAX_BITS} can be written")
    if value is None or type(value) in (bool, int, str):
        return value
    if isinstance(value, float):
        if math.isfinite(value):
            return float(value)
        if row:
            return {"!float": str(float(value))}
        raise _unencodable(value, at, f"{value} is not finite, and JSON has no such number")
    inside = depth + 1
    if isinstance(value, (list, tuple)) and type(value) in (list, tuple):
        items = [_encode(each, f"{at}[{i}]", row=row, depth=inside) for i, each in enumerate(value)]
        return items if row or isinstance(value, list) else {"!tuple": items}
    if isinstance(value, Mapping):
        for key in value:
            if type(key) is not str or key.startswith(TAG):
                why = f"a key is a string that does not begin with {TAG!r}"
                raise _unencodable(key, f"key {key!r} of {at}", why)
        return {
            key: _encode(each, f"{at}.{key}", row=row, depth=inside) for key, each in value.items()
        }
    if _is_dataclass(value):
        fields = {
            each.name: _encode(
                getattr(value, each.name), f"{at}.{each.name}", row=row, depth=inside
            )
            for each in dataclasses.fields(value)
            if each.init or row
        }
        if row:
            return fields
        if not type(value).__dataclass_params__.frozen:
            raise _unencodable(value, at, "a dataclass that is not frozen may change")
        return {"!dataclass": importable(type(value), "class"), "fields": fields}
    raise _unencodable(value, at, "it cannot be hashed and sent to another process")


def _decode(encoded: Any) -> Any:
    if isinstance(encoded, list):
        return [_decode(each) for each in encoded]
    if not isinstance(encoded, dict):
        return encoded
    if encoded.keys() == {"!tuple"}:
        return tuple(_decode(each) for each in encoded["!tuple"])
    if "!dataclass" not in encoded:
        return {key: _decode(each) for key, each in encoded.items()}
    kind = resolve_name(encoded["!dataclass"])
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        raise _unencodable(kind, encoded["!dataclass"], "not a dataclass")
    return kind(**{key: _decode(each) for key, each in encoded["fields"].items()})
