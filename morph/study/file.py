"""A study in a TOML file: a function, its cases one by one, and products of lists."""

from __future__ import annotations

import difflib
import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from morph.errors import StudyError
from morph.study.cell import Cell, check_name
from morph.toml_file import load_toml

MAX_BYTES = 1_000_000
"""Largest file, bytes: many times as much memory is needed to read it."""

MAX_CELLS = 100_000
"""Greatest number of cells of a study."""

MAX_ENTRIES = 1_000
"""Greatest number of entries of a case, of lists of a grid, and of files of data."""

MAX_LETTERS = 50_000_000
"""Greatest length of all cases of a grid together, written out."""

KEYS = ("name", "function", "data", "cell", "grid")

NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,99}")
RANGE = re.compile(r"(-?\d{1,18}):(-?\d{1,18})")


@dataclass(frozen=True, kw_only=True)
class StudyFile:
    """Study that a TOML file describes."""

    file: Path
    """The file."""
    name: str
    """Name of the study; by default the file's name without suffix."""
    function: str
    """Function of all cells."""
    cases: Sequence[Mapping[str, Any]]
    """Cases of the `[[cell]]` tables."""
    axes: Mapping[str, Sequence[Any]]
    """Lists of the `[grid]`, whose product follows them; empty without one."""
    data: tuple[Path, ...]
    """Files that the function reads."""
    path: tuple[Path, ...]
    """Folders for `sys.path`: that of the file, then the current one."""

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """Cells of the `[[cell]]` tables, then those of the `[grid]`.

        Raises:
            StudyError: A case holds a value that no cell may have.
        """
        grid = itertools.product(*self.axes.values()) if self.axes else ()
        cases = (*self.cases, *(dict(zip(self.axes, case, strict=True)) for case in grid))
        with _named(self.file):
            return tuple(
                Cell(function=self.function, case=case, data=self.data, path=self.path)
                for case in cases
            )


def load_study(path: Path) -> StudyFile:
    """Return the study that a file describes.

    Raises:
        StudyError: It is no regular file, too large, no TOML, or has an unknown key or a wrong
            value.
    """
    table = _toml(path)
    for key in table:
        if key not in KEYS:
            near = difflib.get_close_matches(key, KEYS, n=1) or KEYS
            raise _error(path, f"unknown key {key!r}", f"write {' or '.join(map(repr, near))}")
    name = _text(path, table, "name", default=path.stem)
    if not NAME.fullmatch(name):
        raise _error(path, f"name = {name!r}", "use letters, digits, '.', '_' and '-'")
    function = _text(path, table, "function")
    with _named(path):
        check_name(function)
    folders = (path.absolute().parent, Path.cwd())
    data = tuple(folders[0] / each for each in _texts(path, table))
    cases, axes = _one_by_one(path, table.get("cell", [])), _grid(path, table.get("grid"))
    count = len(cases) + (math.prod(map(len, axes.values())) if axes else 0)
    if not count:
        raise _error(path, "no cells", "add [[cell]] tables, or a [grid] of lists")
    if count > MAX_CELLS:
        raise _error(path, f"{count} cells", f"ask for at most {MAX_CELLS}")
    letters = (count - len(cases)) * sum(len(key) + _length(axes[key]) for key in axes)
    if letters > MAX_LETTERS:
        what = f"the cases of the grid have up to {letters} letters together"
        raise _error(path, what, f"ask for at most {MAX_LETTERS}: fewer cells, or shorter values")
    return StudyFile(
        file=path, name=name, function=function, cases=cases, axes=axes, data=data, path=folders
    )


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Name the file in an error of one of its cells."""
    try:
        yield
    except StudyError as error:
        raise _error(path, error.what, error.fix) from error


def _toml(path: Path) -> dict[str, Any]:
    try:
        return load_toml(path, MAX_BYTES)[0]
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or " ".join(str(error).split())[:200]
        fix = f"name a TOML file of at most {MAX_BYTES} bytes: docs/study.md"
        raise _error(path, f"cannot be read: {why}", fix) from error


def _one_by_one(path: Path, table: Any) -> list[dict[str, Any]]:
    if not isinstance(table, list) or not all(isinstance(each, dict) for each in table):
        raise _error(path, "`cell` is no list of tables", "write [[cell]] above each case")
    most = max(map(len, table), default=0)
    if most > MAX_ENTRIES:
        raise _error(path, f"a cell has {most} entries", f"give it at most {MAX_ENTRIES}")
    return table


def _grid(path: Path, table: Any) -> dict[str, list[Any] | range]:
    if table is None:
        return {}
    if not isinstance(table, dict) or not table:
        raise _error(path, "`grid` is no table of lists", 'write x = [1, 2] or seed = "0:10"')
    if len(table) > MAX_ENTRIES:
        raise _error(path, f"`grid` has {len(table)} lists", f"give it at most {MAX_ENTRIES}")
    return {key: _axis(path, key, values) for key, values in table.items()}


def _axis(path: Path, key: str, values: Any) -> list[Any] | range:
    if isinstance(values, str):
        match = RANGE.fullmatch(values)
        axis: list[Any] | range = range(*map(int, match.groups())) if match else []
        if match and len(axis) > MAX_CELLS:
            raise _error(path, f"grid.{key} has {len(axis)} values", f"at most {MAX_CELLS}")
    else:
        axis = values if isinstance(values, list) else []
    if not axis:
        raise _error(
            path,
            f"grid.{key} = {_shown(values)} holds no values",
            'write a list, or a range of whole numbers such as "0:10"',
        )
    return axis


def _length(axis: list[Any] | range) -> int:
    """Return the length of an axis's longest value, written out."""
    return max(
        len(_written(each)) for each in ((axis[0], axis[-1]) if isinstance(axis, range) else axis)
    )


def _shown(value: Any) -> str:
    return _written(value)[:60]


def _written(value: Any) -> str:
    try:
        return repr(value)
    except ValueError:  # Python writes no integer of more than 4,300 digits.
        return "an integer of thousands of digits"


def _text(path: Path, table: Mapping[str, Any], key: str, default: str | None = None) -> str:
    value = table.get(key, default)
    if not isinstance(value, str):
        what = f"no {key}" if value is None else f"{key} = {_shown(value)} is no text"
        raise _error(path, what, f'write {key} = "..."')
    return value


def _texts(path: Path, table: Mapping[str, Any]) -> list[str]:
    value = table.get("data", [])
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        raise _error(path, f"data = {_shown(value)} is no list of paths", 'write data = ["a.csv"]')
    if len(value) > MAX_ENTRIES:
        raise _error(path, f"data names {len(value)} files", f"name at most {MAX_ENTRIES}")
    return value


def _error(path: Path, what: str, fix: str) -> StudyError:
    return StudyError(what, where=str(path), fix=fix)
