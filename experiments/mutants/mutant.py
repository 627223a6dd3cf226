"""Mutants as data: the text to replace, its file, and the tests that should fail."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from morph.errors import MorphError

KEYS = {"file", "text", "replacement", "breaks"}
"""Keys that a mutant must have; `first` is optional."""


class MutantError(MorphError):
    """A list of mutants cannot be used, or a mutant does not apply."""


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """One small bug: a replacement of text in a file."""

    area: str
    """The area that it belongs to."""
    file: str
    """The file, relative to the repository."""
    text: str
    """Text to replace, which occurs once in the file."""
    replacement: str
    """Text in its place."""
    breaks: str
    """Description of the bug."""
    first: tuple[str, ...]
    """Tests that most probably fail, run before the others; empty for none."""
    rest: tuple[str, ...]
    """The other tests of its area, the fastest first."""

    def apply(self, source: str) -> str:
        """Return the file's text with the bug in it.

        Raises:
            MutantError: The text to be replaced does not occur exactly once.
        """
        count = source.count(self.text)
        if count != 1 or self.text == self.replacement:
            raise MutantError(
                f"the text of the mutant `{self.breaks}` occurs {count} times, or is replaced by "
                "itself",
                where=self.file,
                fix=f"mend its entry in experiments/mutants/{self.area}.toml: a text that occurs "
                "once, and another in its place",
            )
        return source.replace(self.text, self.replacement)


@dataclass(frozen=True, kw_only=True)
class Area:
    """A part of the code, the tests that watch over it, and the bugs planted in it."""

    name: str
    """Name of its file, without suffix."""
    tests: tuple[str, ...]
    """Arguments for pytest, the fastest first."""
    mutants: tuple[Mutant, ...]
    """In the order of the file."""


def load_areas(folder: Path, only: str | None = None) -> tuple[Area, ...]:
    """Return the areas of a folder of TOML files, sorted by name.

    Args:
        folder: Folder with one file an area.
        only: Name of a single area; None for all.

    Raises:
        MutantError: A file cannot be read, lacks a key, or the area is unknown.
    """
    files = {path.stem: path for path in sorted(folder.glob("*.toml"))}
    if not files or (only is not None and only not in files):
        raise MutantError(
            f"there is no area {only!r}" if files else "there is no list of mutants",
            where=str(folder),
            fix=f"choose one of {', '.join(files)}" if files else "name a folder of TOML files",
        )
    return tuple(_area(path) for name, path in files.items() if only in (None, name))


def _area(path: Path) -> Area:
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise MutantError(str(error), where=str(path), fix="mend the file") from error
    tests, rows = table.get("tests"), table.get("mutant")
    if not tests or not rows:
        raise MutantError(
            "it has no `tests` or no [[mutant]]",
            where=str(path),
            fix='give tests = ["tests/..."], the fastest first, and a mutant or more',
        )
    return Area(
        name=path.stem,
        tests=tuple(tests),
        mutants=tuple(_mutant(path, row, tuple(tests)) for row in rows),
    )


def _mutant(path: Path, row: dict[str, Any], tests: tuple[str, ...]) -> Mutant:
    first = tuple(row.pop("first", ()))
    if set(row) != KEYS or not all(isinstance(value, str) for value in row.values()):
        raise MutantError(
            f"a mutant has {', '.join(sorted(row))}",
            where=str(path),
            fix=f"give {', '.join(sorted(KEYS))} as texts, and `first`, tests to begin with",
        )
    rest = tuple(test for test in tests if test not in first)
    return Mutant(area=path.stem, first=first, rest=rest, **row)
