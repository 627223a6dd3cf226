"""Typed access to an untrusted JSON table."""

from __future__ import annotations

import math
from typing import Any

from morph.errors import ViewError

LONGEST = 2000
"""Characters of one text; more is cut off."""


class Said:
    """A JSON object whose values are checked when they are asked for.

    Args:
        content: What `json.loads` gave.
        where: The file and the place in it, for errors.

    Raises:
        ViewError: It is no object.
    """

    def __init__(self, content: Any, *, where: str) -> None:
        """Check that it is an object."""
        if not isinstance(content, dict):
            raise _bad(where, "", "an object", content)
        self.content: dict[str, Any] = content
        self.where = where

    def text(self, key: str, *, default: str | None = None) -> str:
        """Return a text."""
        value = self.content.get(key, default)
        if not isinstance(value, str):
            raise _bad(self.where, key, "a text", value)
        return value[:LONGEST]

    def number(self, key: str, *, default: float | None = None) -> float:
        """Return a finite number."""
        value = self.content.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _bad(self.where, key, "a number", value)
        # An integer of hundreds of digits is beyond any float.
        if (isinstance(value, int) and value.bit_length() > 1000) or not math.isfinite(value):
            raise _bad(self.where, key, "a finite number", "one that is not")
        return float(value)

    def table(self, key: str) -> Said:
        """Return an object."""
        return Said(self.content.get(key), where=f"{self.where}, {key}"[:LONGEST])

    def tables(self, key: str) -> tuple[Said, ...]:
        """Return a list of objects."""
        return tuple(
            Said(each, where=f"{self.where}, {key} {number}")
            for number, each in enumerate(self._list(key), start=1)
        )

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of texts."""
        values = self._list(key)
        for value in values:
            if not isinstance(value, str):
                raise _bad(self.where, key, "a list of texts", value)
        return tuple(value[:LONGEST] for value in values)

    def of_texts(self) -> dict[str, str]:
        """Return the whole, of which every value must be a text."""
        return {key: self.text(key) for key in self.content}

    def _list(self, key: str) -> list[Any]:
        value = self.content.get(key)
        if not isinstance(value, list):
            raise _bad(self.where, key, "a list", value)
        return value


def _bad(where: str, key: str, wanted: str, value: object) -> ViewError:
    result = "nothing" if value is None else repr(value)[:80]
    return ViewError(
        f"{key or 'it'} is not {wanted} but {result}",
        where=where,
        fix="give the file as `morph diagnose` wrote it",
    )
