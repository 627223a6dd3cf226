"""Values out of JSON that anyone may have written, or a refusal that names the place."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from morph.arrays import JSON
from morph.errors import ViewError
from morph.policy.fields import most_of

Read = TypeVar("Read")

LONGEST = 200
"""Most letters of a name; sentences may have ten times as many."""

LARGEST = 1e300
"""Greatest number."""


class RecordValues:
    """An object of a record, with its place.

    Args:
        said: What JSON gave.
        where: The file, and the place in it.
    """

    def __init__(self, document: Any, where: str) -> None:
        """Take an object.

        Raises:
            ViewError: It is something else.
        """
        self.where = where
        if not isinstance(document, dict):
            raise self.refused(f"there stands {most_of(document)}, not an object")
        self._said: JSON = document

    def has(self, key: str) -> bool:
        """Return whether there is something under a key that is not null."""
        return self._said.get(key) is not None

    def text(self, key: str, most: int = LONGEST) -> str:
        """Return a text of bounded length; control characters are shown as spaces."""
        return self._text(self._said.get(key), key, most)

    def number(self, key: str, low: float = -LARGEST, high: float = LARGEST) -> float:
        """Return a finite number of a range."""
        result = self._number(self._said.get(key), key)
        if not low <= result <= high:
            raise self.refused(f"{key} is {result:g}, not from {low:g} to {high:g}")
        return result

    def maybe(self, key: str) -> float:
        """Return a number, or NaN if it is null."""
        return self._number(self._said[key], key) if self.has(key) else math.nan

    def inside(self, key: str) -> RecordValues:
        """Return the object under a key."""
        return RecordValues(self._said.get(key), f"{self.where}, {key}")

    def numbers(self, key: str) -> dict[str, float]:
        """Return the numbers under a key by name, NaN for null."""
        inside = self.inside(key)
        return {inside._text(name, name): inside.maybe(name) for name in inside._said}

    def texts_by_name(self, key: str) -> dict[str, str]:
        """Return the texts under a key by name."""
        inside = self.inside(key)
        return {inside._text(name, name): inside.text(name) for name in inside._said}

    def each(self, key: str, of: Callable[[RecordValues], Read], most: int) -> tuple[Read, ...]:
        """Return what is made of each object of a list of bounded length."""
        return tuple(
            of(RecordValues(one, f"{self.where}, {key} {at}"))
            for at, one in enumerate(self._list(key, most), 1)
        )

    def texts(self, key: str, most: int, letters: int = LONGEST) -> tuple[str, ...]:
        """Return a list of texts."""
        return tuple(self._text(one, key, letters) for one in self._list(key, most))

    def list_of_numbers(self, key: str, most: int) -> list[float]:
        """Return a list of numbers, NaN for null."""
        return [
            math.nan if one is None else self._number(one, key) for one in self._list(key, most)
        ]

    def refused(self, what: str) -> ViewError:
        """Return the error that tells what is wrong here."""
        return ViewError(
            what,
            where=self.where,
            fix="give a folder that `morph align` or `morph transfer` wrote, as it wrote it",
        )

    def _list(self, key: str, most: int) -> list[Any]:
        value = self._said.get(key)
        if not isinstance(value, list):
            raise self.refused(f"{key} is {most_of(value)}, not a list")
        if len(value) > most:
            raise self.refused(f"{key} has {len(value)} entries, where {most} may be")
        return value

    def _text(self, value: Any, key: str, most: int = LONGEST) -> str:
        if not isinstance(value, str) or len(value) > most:
            raise self.refused(f"{key} is {most_of(value)}, not a text of at most {most} letters")
        return "".join(letter if letter.isprintable() else " " for letter in value)

    def _number(self, value: Any, key: str) -> float:
        # JSON's integers know no bound; a bool is an int.
        plain = isinstance(value, int | float) and not isinstance(value, bool)
        if not plain or not abs(value) <= LARGEST:
            raise self.refused(f"{key} is {most_of(value)}, not a finite number")
        return float(value)
