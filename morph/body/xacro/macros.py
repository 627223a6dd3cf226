"""Expansion by the `xacro` package, with its reader, its reckoner and its finder replaced by ours.

Imported only in the process of `xacro_child`: it changes the package for good.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any
from xml.dom import minidom

import xacro

from morph.body.xacro.document import PlacedElement, Writer, document
from morph.body.xacro.expression import Evaluator
from morph.body.xacro.folder import Folder
from morph.body.xacro.functions import CONSTANTS, LONGEST_TEXT, bounded
from morph.body.xacro.text import tokens
from morph.body.xacro.values import Surroundings
from morph.body.xml import MOST_BYTES, parse
from morph.errors import RobotError

MOST_STEPS = 100_000
"""Steps of reckoning; a robot of 2500 elements takes some 8000."""

DEEPEST = 600
"""Elements and macros inside each other while they are expanded; a loop is a macro in itself."""

LONGEST_PARAMS = 10_000
"""Characters in a macro's list of parameters."""

ORIGINAL: dict[str, Callable[..., Any]] = {
    name: getattr(xacro, name)
    for name in (
        *("eval_all", "process_include", "grab_property", "grab_macro", "handle_macro_call"),
        *("check_attrs", "reqd_attrs"),
    )
}
"""Functions of xacro that stay, each in a wrapping that knows the place."""

LESS = "describe one robot: fewer and shorter macros and properties"

MACRO_ARG = re.compile(
    r"^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?"
    r"""(\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"]++)++|)(?:\s+|$)(.*)"""
)
"""xacro's own pattern for a parameter takes time that doubles with each character of a long one."""


@dataclass(frozen=True, kw_only=True)
class Expanded:
    """What a file expands to."""

    text: bytes
    """URDF."""
    places: list[tuple[int, int]]
    """For each element of the text, in order: the index of its file, and its line."""
    files: list[str]
    """The files."""


def expand(path: Path, folder: Path, arguments: Mapping[str, str], elements: int) -> Expanded:
    """Return what a file expands to.

    Raises:
        RobotError: It does not expand, or grows beyond bounds.
    """
    sys.setrecursionlimit(6000)
    expansion = _Expansion(Folder(folder), dict(arguments), elements)
    expansion.take_over()
    try:
        root = expansion.run(path)
    except RobotError:
        raise
    except RecursionError as error:
        raise expansion.error("leads on and on", LESS) from error
    except (Exception, SystemExit) as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise expansion.error(f"does not expand: {text[:500]}", "correct the line") from error
    writer = Writer()
    writer.write(root)
    files = sorted({file for file, _ in writer.places})
    index = {file: number for number, file in enumerate(files)}
    return Expanded(
        text="".join(writer.parts).encode(),
        places=[(index[file], line) for file, line in writer.places],
        files=files,
    )


class _Expansion:
    """One expansion: what it may read, what it has used up, and where it stands."""

    def __init__(self, folder: Folder, arguments: dict[str, str], elements: int) -> None:
        self.folder, self.arguments, self.most = folder, arguments, elements
        self.elements = self.steps = self.characters = self.depth = 0
        self.nodes: list[PlacedElement] = []
        self.failed: PlacedElement | None = None
        surroundings = Surroundings(folder, arguments, self._here, self.where)
        self.command = surroundings.command
        self.evaluator = Evaluator(surroundings.functions(), self._step)
        surroundings.evaluator = self.evaluator

    def take_over(self) -> None:
        """Put our functions in the place of xacro's."""
        names = xacro.NameSpace()
        for name, value in CONSTANTS.items():
            dict.__setitem__(names, name, value)
        changed: dict[str, Any] = {
            "verbosity": 0,
            "_global_symbols": names,
            "re_macro_arg": MACRO_ARG,
            "eval_text": self._text,
            "get_include_files": self._included,
            "parse": self._parse,
            "is_valid_name": lambda name: name.isidentifier(),
            "print_location": lambda: None,
            "warning": lambda *_, **__: None,
        }
        for name, function in ORIGINAL.items():
            wrap = self._noted if name.endswith("_attrs") else self._placed
            changed[name] = wrap(function)
        for name, value in changed.items():
            setattr(xacro, name, value)

    def run(self, path: Path) -> minidom.Element:
        """Return the root of the expanded tree."""
        xacro.init_stacks(str(path))
        made = self._parse(None, str(path))
        xacro.process_doc(made, mappings=self.arguments)
        root = made.documentElement
        if root is None:
            raise self.error("expands to nothing", "describe a robot")
        return root

    def where(self) -> str:
        """Return the file and line of what is being expanded, or of what failed."""
        node = self.failed or (self.nodes[-1] if self.nodes else None)
        return f"{node.place[0]}:{node.place[1]}" if node else str(self._here())

    def error(self, what: str, fix: str) -> RobotError:
        """Return an error at the place reached."""
        return RobotError(what, where=self.where(), fix=fix)

    def _here(self) -> Path:
        return Path(xacro.filestack[-1] if xacro.filestack else "")

    def _placed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of xacro that remembers which element it was called with."""

        @wraps(function)
        def called(node: Any, *rest: Any) -> Any:
            self.failed = None
            if isinstance(node, PlacedElement):
                self.nodes.append(node)
            self._element(1)
            self.depth += 1
            if self.depth > DEEPEST:
                raise self.error(f"nests deeper than {DEEPEST} elements and macros", LESS)
            if function.__name__ == "grab_macro":
                self._check_params(node)
            try:
                return function(node, *rest)
            except BaseException:
                self.failed = self.failed or (node if isinstance(node, PlacedElement) else None)
                raise
            finally:
                self.depth -= 1
                if isinstance(node, PlacedElement):
                    self.nodes.pop()

        return called

    def _noted(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of xacro that notes its element as the place reached."""

        @wraps(function)
        def called(node: Any, *rest: Any) -> Any:
            if isinstance(node, PlacedElement) and self.nodes:
                self.nodes[-1] = node
            return function(node, *rest)

        return called

    def _check_params(self, node: PlacedElement) -> None:
        if len(node.getAttribute("params")) > LONGEST_PARAMS:
            raise self.error(f"has more than {LONGEST_PARAMS} characters of parameters", LESS)

    def _element(self, number: int) -> None:
        self.elements += number
        if self.elements > self.most:
            raise self.error(f"expands in more than {self.most} steps", LESS)

    def _step(self, number: int) -> None:
        self.steps += number
        if self.steps > MOST_STEPS:
            raise self.error(f"reckons in more than {MOST_STEPS} steps", LESS)

    def _text(self, text: str, symbols: Mapping[str, Any]) -> Any:
        """Return a text with its expressions and commands worked out; one alone keeps its type."""
        if "$" not in text:
            return text
        parts = [self._part(kind, piece, symbols) for kind, piece in tokens(text, self.where())]
        try:
            self._step(len(parts) + bounded(parts) // 1024)
            value = parts[0] if len(parts) == 1 else "".join(map(str, parts))
            self.characters += len(value) if isinstance(value, str) else 0
            if self.characters <= MOST_BYTES:
                return value
        except ValueError:
            pass
        raise self.error(
            f"makes a text of more than {LONGEST_TEXT} characters, or {MOST_BYTES} in all", LESS
        )

    def _part(self, kind: str, piece: str, symbols: Mapping[str, Any]) -> Any:
        if kind == "text":
            return piece
        inner = str(self._text(piece, symbols))
        if kind == "expression":
            return self.evaluator.value(inner, symbols, self.where())
        return self.command(inner)

    def _included(self, written: str, symbols: Mapping[str, Any]) -> Iterator[str]:
        name = str(self._text(written, symbols))
        for path in self.folder.matches(name, self._here().parent, self.where()):
            yield str(path)

    def _parse(self, _text: Any, filename: str) -> minidom.Document:
        try:
            content = self.folder.read(Path(filename), self.where())
        except FileNotFoundError as error:
            xacro.filestack.pop()
            raise xacro.XacroException(f"{filename} is not there", exc=error) from error
        root = parse(content, filename)
        self._element(sum(1 for _ in root.everything()))
        return document(root, self._element)
