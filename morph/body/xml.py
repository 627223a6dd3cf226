"""XML from strangers: parsed with the line of every element, and within bounds."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from xml.parsers import expat

from morph.errors import RobotError

MOST_BYTES = 4 * 2**20
"""Longest description read, bytes; the longest known to us has 0.4 MiB."""

DEEPEST = 200
"""Deepest nesting. A chain of links nests no deeper than this in MJCF."""

MOST_ELEMENTS = 50_000
"""Most elements; ten times those of the largest robot known to us."""

MOST_ATTRIBUTES, LONGEST_NAME = 100, 200
"""Most attributes of an element, and most characters of its tag and of their names."""


class Element(ElementTree.Element):
    """An element that knows where it stands."""

    file: str = ""
    """The file that it was read from."""
    line: int = 0
    """Its line in that file, from 1."""

    @property
    def place(self) -> str:
        """Its file and line, for a message."""
        return f"{self.file}:{self.line}"

    def children(self, *tags: str) -> Iterator[Element]:
        """Yield the children with one of these tags, in order; all of them if none is given."""
        for child in self:
            if isinstance(child, Element) and (not tags or child.tag in tags):
                yield child

    def child(self, tag: str) -> Element | None:
        """Return the first child with a tag, or None."""
        return next(self.children(tag), None)

    def everything(self) -> Iterator[Element]:
        """Yield this element and all below it, in the order of the file."""
        for element in self.iter():
            if isinstance(element, Element):
                yield element


def parse(
    content: bytes, where: str, *, most: int = MOST_BYTES, elements: int = MOST_ELEMENTS
) -> Element:
    """Return the root element of an XML document.

    No entity is expanded and nothing outside the text is opened.

    Args:
        content: The document.
        where: Its file's name, for errors.
        most: Most bytes that it may have.
        elements: Most elements that it may have.

    Raises:
        RobotError: It is not XML, declares entities, or is larger or deeper than
            any description is; the line is named.
    """
    if len(content) > most:
        raise RobotError(
            f"has {len(content)} bytes; {most} are read at most",
            where=where,
            fix="describe shapes in mesh files, not in the description",
        )
    if not content.strip():
        raise RobotError("is empty", where=where, fix="give a description with a body in it")
    if b"\0" in content[:4096] and not content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise RobotError("is binary, not text", where=where, fix="give a description in UTF-8 XML")
    return _Builder(where, elements).build(content)


ENCODINGS = re.compile(
    r"utf-?(8|16)|(us-)?ascii|latin-?1|iso-8859-\d+|(windows-|cp)125\d|koi8-[ru]"
)
"""Encodings that are read, as a description's first line names them, in small letters."""

INVALID_TOKEN = expat.errors.codes[expat.errors.XML_ERROR_INVALID_TOKEN]


def _is_text(content: bytes) -> bool:
    try:
        content.decode()
    except UnicodeDecodeError:
        return False
    return True


class _Builder:
    """Builds the tree while expat reads."""

    def __init__(self, where: str, elements: int) -> None:
        self.where, self.elements = where, elements
        self.root: Element | None = None
        self.stack: list[Element] = []
        self.texts: list[list[str]] = []
        self.count = 0
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.XmlDeclHandler = self._declaration
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.EntityDeclHandler = self._entity
        self.parser.AttlistDeclHandler = self._defaults
        self.parser.StartDoctypeDeclHandler = self._doctype

    def build(self, content: bytes) -> Element:
        try:
            self.parser.Parse(content, True)
        except expat.ExpatError as error:
            if error.code == INVALID_TOKEN and not _is_text(content):
                raise RobotError(
                    "is binary, not text", where=self.where, fix="give a description in UTF-8 XML"
                ) from error
            raise RobotError(
                f"is not XML: {expat.ErrorString(error.code)}",
                where=f"{self.where}:{error.lineno}",
                fix="correct the line; an XML checker shows what is open or misspelt",
            ) from error
        except (ValueError, LookupError) as error:  # Bytes that the encoding has not.
            raise RobotError(
                f"is not XML: {error}", where=self.where, fix="save the description as UTF-8"
            ) from error
        if self.root is None:
            raise RobotError("has no element", where=self.where, fix="give a description")
        return self.root

    def _here(self) -> str:
        return f"{self.where}:{self.parser.CurrentLineNumber}"

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if len(self.stack) >= DEEPEST or self.count > self.elements:
            self._refuse(f"nests deeper than {DEEPEST} elements or has more than {self.elements}")
        if len(attributes) > MOST_ATTRIBUTES:
            self._refuse(f"has an element with {len(attributes)} attributes")
        longest = max(map(len, (tag, *attributes)))
        if longest > LONGEST_NAME:
            self._refuse(f"has a tag or an attribute whose name has {longest} characters")
        element = Element(tag, attributes)
        element.file, element.line = self.where, self.parser.CurrentLineNumber
        if self.stack:
            self.stack[-1].append(element)
        else:
            self.root = element
        self.stack.append(element)
        self.texts.append([])

    def _refuse(self, what: str) -> None:
        fix = "describe one robot, without generated filler"
        raise RobotError(what, where=self._here(), fix=fix)

    def _end(self, _tag: str) -> None:
        element, texts = self.stack.pop(), self.texts.pop()
        if texts:
            element.text = "".join(texts)

    def _text(self, text: str) -> None:
        if not text.isspace():
            self.texts[-1].append(text)

    def _declaration(self, _version: str, encoding: str | None, _standalone: int) -> None:
        # Python has codecs that are no encodings of texts, and some that warn.
        if encoding is not None and not ENCODINGS.fullmatch(encoding.lower()):
            raise RobotError(
                f"is not XML that can be read: its encoding is {encoding[:80]!r}",
                where=self._here(),
                fix="save the description as UTF-8",
            )

    def _doctype(self, name: str, system: str | None, *_rest: object) -> None:
        if system is not None:
            raise RobotError(
                f"wants its document type {name[:80]!r} fetched from {system[:80]!r}",
                where=self._here(),
                fix="remove the DOCTYPE line; descriptions need none",
            )

    def _entity(self, name: str, *_declaration: object) -> None:
        raise RobotError(
            f"declares the entity {name[:80]!r}, and descriptions from strangers may not",
            where=self._here(),
            fix="write the text where the entity stands, and remove its declaration",
        )

    def _defaults(self, element: str, *_declaration: object) -> None:
        # Each element would get a default's text: a bomb without an entity.
        raise RobotError(
            f"declares attributes of <{element[:80]}> in its document type",
            where=self._here(),
            fix="remove the DOCTYPE; descriptions need none",
        )
