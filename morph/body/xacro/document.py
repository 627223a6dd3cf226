"""The document that xacro works on: made from ours, so that each element knows its line."""

from __future__ import annotations

import re
from collections.abc import Callable
from xml.dom import minidom

from morph.body.xml import MOST_BYTES, Element
from morph.errors import RobotError

NAME = re.compile(r"[^\W\d][\w:.\-]*")
"""Names of elements and attributes that may be written."""

UNFIT = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold."""

ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"}
    | {mark: f"&#{ord(mark)};" for mark in "\t\n\r"}
)


class Counted(minidom.Document):
    """A document that tells how many copies of its elements are made.

    Args:
        count: Told of each copy; may raise to stop.
    """

    def __init__(self, count: Callable[[int], None]) -> None:
        super().__init__()
        self.count = count


class PlacedElement(minidom.Element):
    """An element that knows where it stands."""

    def __init__(self, tag: str, place: tuple[str, int], owner: Counted) -> None:
        super().__init__(tag)
        self.ownerDocument = owner
        self.place = place
        self.owner = owner

    # The name is minidom's.
    def cloneNode(self, deep: bool) -> PlacedElement:
        """Return a copy that stands at the same place."""
        self.owner.count(1)
        copy = PlacedElement(self.tagName, self.place, self.owner)
        for name, value in self.attributes.items():
            copy.setAttribute(name, value)
        for child in self.childNodes if deep else ():
            if isinstance(child, (PlacedElement, minidom.Text)):
                copy.appendChild(child.cloneNode(True))  # type: ignore[type-var]
        return copy


def document(root: Element, count: Callable[[int], None]) -> Counted:
    """Return the document of a tree of elements; it has no comments and no white space."""
    made = Counted(count)
    made.appendChild(_copied(root, made))
    return made


def _copied(element: Element, owner: Counted) -> PlacedElement:
    made = PlacedElement(element.tag, (element.file, element.line), owner)
    for name, value in element.attrib.items():
        made.setAttribute(name, value)
    if element.text:
        made.appendChild(owner.createTextNode(element.text))
    for child in element.children():
        made.appendChild(_copied(child, owner))
    return made


class Writer:
    """Writes a tree as XML."""

    def __init__(self) -> None:
        self.parts: list[str] = []
        self.places: list[tuple[str, int]] = []
        """The place of each element, in the order of the text."""
        self.length = 0

    def write(self, node: minidom.Element) -> None:
        """Add an element and all below it.

        Raises:
            RobotError: A name or a text has characters that XML cannot hold, or the
                text grows longer than any description.
        """
        place = node.place if isinstance(node, PlacedElement) else ("", 0)
        self.places.append(place)
        attributes = node.attributes.items()
        for name in (node.tagName, *(name for name, _ in attributes)):
            if not NAME.fullmatch(name):
                raise _unfit(f"makes up the name {name[:80]!r}", place)
        self._add(f"<{node.tagName}", place)
        for name, value in attributes:
            self._add(f' {name}="', place)
            self._add(value.translate(ESCAPES), place)
            self._add('"', place)
        self._add(">", place)
        for child in node.childNodes:
            if isinstance(child, minidom.Element):
                self.write(child)
            elif isinstance(child, minidom.Text) and not child.data.isspace():
                self._add(child.data.translate(ESCAPES), place)
        self._add(f"</{node.tagName}>\n", place)

    def _add(self, text: str, place: tuple[str, int]) -> None:
        self.length += len(text)
        if self.length > MOST_BYTES:
            raise RobotError(
                f"expands to more than {MOST_BYTES} characters",
                where=f"{place[0]}:{place[1]}",
                fix="describe one robot: fewer and shorter macros and properties",
            )
        unfit = UNFIT.search(text)
        if unfit:
            raise _unfit(f"makes up a text with {unfit[0]!r}", place)
        self.parts.append(text)


def _unfit(what: str, place: tuple[str, int]) -> RobotError:
    return RobotError(
        f"{what}, which XML does not allow",
        where=f"{place[0]}:{place[1]}",
        fix="use letters, digits, - and _ in names, and no control characters in texts",
    )
