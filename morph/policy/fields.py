"""Single values out of JSON that anyone may have written, or a refusal that names the key."""

from __future__ import annotations

from typing import Any

from morph.arrays import JSON
from morph.errors import PolicyError

LONGEST = 200
"""Most characters of a text."""

LARGEST = 1e100
"""Greatest number."""


def most_of(value: object) -> str:
    """Return a value as it is written, but not more than is read at a glance."""
    try:
        text = repr(value)
    except RecursionError:
        return "nested too deeply"
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def whole_of(document: Any, where: str) -> JSON:
    """Return what is said, if it is an object.

    Raises:
        PolicyError: It is something else.
    """
    if not isinstance(document, dict):
        raise _refused(f"it holds {most_of(document)}, not an object", where)
    return document


def text_of(document: JSON, key: str, where: str) -> str:
    """Return a text of bounded length.

    Raises:
        PolicyError: It is missing or something else.
    """
    value = document.get(key)
    if not isinstance(value, str) or len(value) > LONGEST:
        raise _refused(f"{key} is {most_of(value)}, not a text of at most {LONGEST} letters", where)
    return value


def number_of(document: JSON, key: str, where: str) -> float:
    """Return a finite number.

    Raises:
        PolicyError: It is missing or something else.
    """
    value = document.get(key)
    # JSON's integers know no bound; a thousand digits are no float. A bool is an int.
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST:
        return float(value)
    raise _refused(f"{key} is {most_of(value)}, not a finite number", where)


def table_of(document: JSON, key: str, where: str) -> JSON:
    """Return an object within an object.

    Raises:
        PolicyError: It is missing or something else.
    """
    value = document.get(key)
    if not isinstance(value, dict):
        raise _refused(f"{key} is {most_of(value)}, not an object", where)
    return value


def tables_of(document: JSON, key: str, most: int, where: str) -> list[JSON]:
    """Return a list of objects of bounded length.

    Raises:
        PolicyError: It is missing or something else.
    """
    value = document.get(key)
    right = isinstance(value, list) and len(value) <= most
    if not right or not all(isinstance(each, dict) for each in value or ()):
        raise _refused(f"{key} is {most_of(value)}, not a list of at most {most} objects", where)
    return list(value or ())


def _refused(what: str, where: str) -> PolicyError:
    return PolicyError(what, where=where, fix="give a policy of morph's own")
