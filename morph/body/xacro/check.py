"""A look through xacro files before anything is expanded."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from morph.body.xacro.bound import MOST_EXPANDED, ExpansionBound
from morph.body.xacro.expression import checked
from morph.body.xacro.folder import Folder
from morph.body.xacro.text import tokens
from morph.body.xml import MOST_BYTES, Element, parse
from morph.errors import RobotError

MOST_FILES = 200
"""Most files that one description includes."""

MOST_EXPRESSION = 2**17
"""Characters in all different expressions together; reading them takes most of the time."""

COMMANDS = ("arg", "dirname", "eval", "find", "optenv")
"""What may stand first in `$(...)`."""


def check(path: Path, folder: Folder, arguments: Mapping[str, str]) -> bool:
    """Return whether the size of what a description expands to is known beforehand.

    Raises:
        RobotError: A file that it includes lies outside its folder or is no XML,
            an expression could do more than reckon, or it would grow beyond all
            robots; the file and line are named.
    """
    look = _Look(folder, arguments)
    root = look.file(path, str(path))
    bound = ExpansionBound(look.included)
    for each in look.roots.values():
        bound.learn(each)
    bound.check(root, path)
    return bound.closed


class _Look:
    """Reads a file and all that it includes, each once."""

    def __init__(self, folder: Folder, arguments: Mapping[str, str]) -> None:
        self.folder = folder
        self.arguments = arguments
        self.roots: dict[Path, Element] = {}
        self.seen: set[str] = set()
        self.bytes = self.elements = self.characters = 0

    def file(self, path: Path, where: str) -> Element:
        """Return the root of a file, after a look at it and at the files that it includes."""
        real = self.folder.inside(path, where)
        if real in self.roots:
            return self.roots[real]
        content = self.folder.read(path, where)
        self.bytes += len(content)
        root = parse(content, str(path))
        self.roots[real] = root
        todo = list(root.everything())
        self.elements += len(todo)
        if self.bytes > MOST_BYTES or self.elements > MOST_EXPANDED or len(self.roots) > MOST_FILES:
            raise RobotError(
                f"has more than {MOST_FILES} files, {MOST_BYTES} bytes or "
                f"{MOST_EXPANDED} elements with all that it includes",
                where=f"{path}:{root.line}",
                fix="describe one robot, without generated filler",
            )
        for element in todo:
            self._element(element)
        for element in todo:
            if element.tag == "xacro:include":
                self.included(element)
        return root

    def included(self, element: Element) -> list[Element] | None:
        """Return the roots that an include means; None if only expansion can tell which."""
        paths = self._targets(element)
        if paths is None:
            return None
        roots = []
        for path in paths:
            try:
                roots.append(self.file(path, element.place))
            except FileNotFoundError as error:
                # Under a condition that does not hold, or optional: expansion decides.
                if not path.is_relative_to(self.folder.root):
                    raise RobotError("is not there", where=str(path), fix="add it") from error
        return roots

    def _targets(self, element: Element) -> list[Path] | None:
        beside = Path(element.file).parent
        written = ""
        for kind, text in tokens(element.get("filename", ""), element.place):
            words = text.split() if kind == "command" else []
            if kind == "text":
                written += text
            elif words[:1] == ["find"] and len(words) == 2 and "$" not in text:
                written += str(self.folder.package(words[1], element.place))
            elif words == ["dirname"]:
                written += str(beside)
            elif words[:1] == ["arg"] and words[-1] in self.arguments:
                written += self.arguments[words[-1]]
            else:
                return None
        return self.folder.matches(written, beside, element.place) if written else []

    def _element(self, element: Element) -> None:
        for text in (*element.attrib.values(), element.text or ""):
            if "$" in text and text not in self.seen:
                self.seen.add(text)
                for kind, content in tokens(text, element.place):
                    if kind == "expression":
                        self._expression(content, element.place)
                    elif kind == "command":
                        self._command(content, element.place)

    def _expression(self, text: str, where: str) -> None:
        # With a command inside, only expansion shows what it will be, and checks it then.
        if "$" not in text:
            self.characters += len(text)
            if self.characters > MOST_EXPRESSION:
                raise RobotError(
                    f"has more than {MOST_EXPRESSION} characters of expressions",
                    where=where,
                    fix="describe one robot, without generated filler",
                )
            checked(text, where)

    def _command(self, text: str, where: str) -> None:
        words = text.split()
        if "$" in text:
            return
        if not words or words[0] not in COMMANDS:
            raise unknown_command(text, where)
        if words[0] == "eval":
            self._expression(text.partition("eval")[2], where)


def unknown_command(text: str, where: str) -> RobotError:
    """Return the error for a command that descriptions from strangers may not give."""
    return RobotError(
        f"has $({text[:80]}), which is not one of {', '.join(COMMANDS)}",
        where=where,
        fix="hand in what it needs as an argument, and read it with $(arg name)",
    )
