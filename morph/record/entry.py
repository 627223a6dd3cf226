"""One table of a `recording.toml`, read strictly, with the line of each key for errors."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from morph.arrays import JSON
from morph.errors import RecordingError
from morph.nearest import nearest


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One table and where it stands."""

    table: JSON
    """Its keys and values."""
    path: Path
    """The file."""
    document: str
    """The file's text, to find lines in."""
    section: str = ""
    """The header that it stands under; empty for the top of the file."""
    at: int = 0
    """Which of the tables under this header, from 0."""
    key: str = ""
    """The key that it is the value of, if it is written inline."""

    def where(self, key: str = "") -> str:
        """Return the file and the line of a key, or of the table itself."""
        lines = self.document.splitlines()
        header = re.compile(rf"\s*\[{{1,2}}\s*{re.escape(self.section)}\s*\]")
        starts = [at for at, line in enumerate(lines) if self.section and header.match(line)]
        first = starts[self.at] if self.at < len(starts) else 0
        for word in filter(None, (self.key, key)):
            pattern = re.compile(rf"(^|[\s,{{\"'.\[]){re.escape(word)}[\"'\s]*[=.\]]")
            first = next(
                (at for at in range(first, len(lines)) if pattern.search(lines[at])), first
            )
        return f"{self.path}:{first + 1}"

    def error(self, what: str, key: str, fix: str) -> RecordingError:
        """Return an error at the line of a key."""
        return RecordingError(what, where=self.where(key), fix=fix)

    def allow(self, *known: str) -> None:
        """Refuse every key but these.

        Raises:
            RecordingError: There is another key.
        """
        for key in self.table:
            if key not in known:
                raise self.error(
                    f"the key {key!r} is unknown; the keys here are {', '.join(known)}",
                    key,
                    f"remove it, or write {nearest(key, known, most=1)}",
                )

    def wrong(self, key: str, what: str) -> RecordingError:
        """Return the error for a value that is not `what`."""
        return self.error(f"{key} is {self.table[key]!r}", key, f"write {what}")

    def text(self, key: str) -> str | None:
        """Return a text; None if the key is missing.

        Raises:
            RecordingError: The value is not a text.
        """
        value = self.table.get(key)
        if value is not None and (not isinstance(value, str) or "\0" in value):
            raise self.wrong(key, "a text in quotes")
        return value

    def number(self, key: str) -> float | None:
        """Return a finite number; None if the key is missing.

        Raises:
            RecordingError: The value is not a finite number.
        """
        value = self.table.get(key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.wrong(key, "a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.wrong(key, "a finite number")
        return number

    def ratio(self, key: str) -> float | None:
        """Return a finite number, also one that is written as a ratio in quotes, as "1/33".

        Raises:
            RecordingError: The value is neither.
        """
        value = self.table.get(key)
        if not isinstance(value, str):
            return self.number(key)
        try:
            over, under = map(float, value.split("/"))
            result = over / under
        except (ValueError, ZeroDivisionError):
            result = math.nan
        if not math.isfinite(result):
            raise self.wrong(key, 'a number, or a ratio in quotes such as "1/33"')
        return result

    def inner(self, value: Any, section: str, *, at: int = 0, key: str = "") -> Entry:
        """Return a table inside this one.

        Raises:
            RecordingError: The value is not a table.
        """
        entry = Entry(
            table=value, path=self.path, document=self.document, section=section, at=at, key=key
        )
        if not isinstance(value, dict):
            name = key or section
            raise entry.error(f"{name} is {value!r}, not a table", "", "write { key = value, ... }")
        return entry
