"""Cell of a study: a function and its case, identified by a hash of both and of their code."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from morph.arrays import JSON
from morph.errors import StudyError
from morph.files import sha256
from morph.regular_file import open_regular
from morph.study.code_hash import RUNNERS, code_hash
from morph.study.encoding import encode_case, importable, modules_of
from morph.study.isolation import isolated

HASH_DIGITS = 32
"""Hexadecimal digits of a hash that are used: 128 bits."""


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One call of a function, which another process can make and whose result a folder can hold.

    Raises:
        StudyError: `function` is not of that form, or the case cannot be hashed or written.
    """

    function: str
    """`package.module:name`; a mapping's entries are its keyword arguments, a dataclass its one."""
    case: Any
    """A mapping or a frozen dataclass of plain values: see `morph.study.encoding`."""
    data: tuple[Path, ...] = ()
    """Files that the function reads; a change of one counts as a change of code."""
    path: tuple[Path, ...] = ()
    """Folders put before the worker's `sys.path`; modules in them count as the cell's code."""
    ignore: tuple[str, ...] = RUNNERS
    """Packages left out of the code hash, as they only run cells: see `morph.study.code_hash`."""

    def __post_init__(self) -> None:
        check_name(self.function)
        object.__setattr__(self, "data", tuple(Path(path) for path in self.data))
        object.__setattr__(self, "path", tuple(Path(path) for path in self.path))
        # A case that cannot be encoded is refused here, not when the cell runs.
        _ = self.encoded

    @cached_property
    def encoded(self) -> JSON:
        """The case as JSON."""
        return encode_case(self.case)

    @cached_property
    def identity(self) -> str:
        """Hash of the function's name and the case; it does not depend on the code."""
        return identity_of(self.function, self.encoded)

    @cached_property
    def modules(self) -> tuple[str, ...]:
        """The modules of the function and of the case's dataclasses."""
        return tuple(sorted({self.function.partition(":")[0], *modules_of(self.encoded)}))

    @cached_property
    def code_by_module(self) -> dict[str, str]:
        """Hash of the source that each of `modules` depends on.

        Raises:
            StudyError: A module does not exist.
        """
        return {name: code_hash(name, path=self.path, ignore=self.ignore) for name in self.modules}

    @cached_property
    def code(self) -> str:
        """Hash of the source that the function and the case's classes depend on, and of the data.

        Raises:
            StudyError: A module does not exist, or a data file cannot be read.
        """
        source = [f"{name} {digits}\n" for name, digits in self.code_by_module.items()]
        return sha256(*source, *(_content(path) for path in self.data))[:HASH_DIGITS]

    @property
    def label(self) -> str:
        """The case in one line, for messages."""
        return label_of(self.encoded)


def identity_of(function: str, encoded: JSON) -> str:
    """Return the hash of a function's name and an encoded case."""
    return sha256(json.dumps([function, encoded], sort_keys=True))[:HASH_DIGITS]


def label_of(encoded: JSON) -> str:
    """Return an encoded case in one line, for messages."""
    entries = encoded["fields"] if "!dataclass" in encoded else encoded
    return ", ".join(f"{name}={_short(value)}" for name, value in entries.items()) or "no entries"


def cells_of(
    function: Callable[..., Any],
    cases: Iterable[Any],
    *,
    data: Iterable[Path] = (),
    path: Iterable[Path] = (),
) -> list[Cell]:
    """Return a cell for each case of one function.

    Args:
        function: Defined at the top level of a module.
        cases: Mappings or frozen dataclasses of plain values (`morph.study.encoding`).
        data: Files that the function reads.
        path: Folders put before the workers' `sys.path`.

    Raises:
        StudyError: The function cannot be found by another process, or a case is not plain.
    """
    name, files, folders = importable(function, "function"), tuple(data), tuple(path)
    return [Cell(function=name, case=case, data=files, path=folders) for case in cases]


def check_cells(cells: Iterable[Cell]) -> None:
    """Check that every cell's function can be imported here and that no two cells are equal.

    Raises:
        StudyError: There are no cells, a function cannot be imported, or two cells are equal.
    """
    seen: dict[str, int] = {}
    functions: set[str] = set()
    number = 0
    for number, cell in enumerate(cells, start=1):
        if cell.identity in seen:
            raise StudyError(
                f"cells {seen[cell.identity]} and {number} are equal: {cell.label}",
                where=cell.function,
                fix="leave one of them out; give repetitions a seed each",
            )
        seen[cell.identity] = number
        if cell.function not in functions:
            check_function(cell.function)
            functions.add(cell.function)
    if not number:
        raise StudyError("no cells", where="morph.study", fix="give at least one case")


def check_name(name: str) -> None:
    """Check that a text has the form of a function's name.

    Raises:
        StudyError: It is not `package.module:name`.
    """
    module, colon, attribute = name.partition(":")
    whole = (*module.split("."), attribute)
    if not colon or not all(part.isidentifier() for part in whole):
        raise StudyError(
            f"{name!r} names no function", where="morph.study", fix="write package.module:function"
        )


def check_function(name: str) -> None:
    """Check that a function can be imported here.

    Raises:
        StudyError: Its module cannot be imported, has nothing of that name, or no function.
    """
    module, _, attribute = name.partition(":")
    try:
        with isolated():
            home = import_module(module)
            names = dir(home)
            target = getattr(home, attribute, None)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # What a module raises may be anything, such as SystemExit.
        raise StudyError(
            f"module {module!r} cannot be imported: {type(error).__name__}: {error}",
            where=name,
            fix="name an importable module that raises nothing; run from the folder that holds it",
        ) from error
    if target is None:
        import difflib

        near = difflib.get_close_matches(attribute, names, n=3)
        raise StudyError(
            f"module {module!r} has no function {attribute!r}",
            where=name,
            fix=f"name one of {near}" if near else "name a function of that module",
        )
    if not callable(target):
        raise StudyError(
            f"{attribute!r} is a {type(target).__name__}", where=name, fix="name a function"
        )


def _content(path: Path) -> str:
    try:
        # `open_regular` refuses a pipe, which would block, and a device, which has no end.
        with open_regular(path):
            state = path.stat()
    except (OSError, ValueError) as error:
        raise StudyError(
            f"declared as data, but cannot be read: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="name a regular file that you may read",
        ) from error
    return f"{path.name} {_digest(path.absolute(), state.st_size, state.st_mtime_ns)}\n"


@cache
def _digest(path: Path, size: int, modified: int) -> str:
    """Return the hash of a file, read once for all cells that declare it."""
    return sha256(path)


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
