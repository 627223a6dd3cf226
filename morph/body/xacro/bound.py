"""How many elements a xacro description can expand to, counted before it is expanded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from morph.body.xml import Element
from morph.errors import RobotError

MOST_EXPANDED = 20_000
"""Most elements in a description's files, and in what it expands to.

The largest of 240 public robots has 2477; what is refused must be refused within a second.
"""

DEEPEST_COUNT = 100
"""Elements and macros inside each other that are counted; what nests deeper is left open."""

CEILING = 10**12
"""Where counting stops to make numbers larger."""


@dataclass(frozen=True)
class Size:
    """Elements made, given those of the block that a caller hands in: own + x * block."""

    own: int = 0
    """Elements whatever the block."""
    x: int = 0
    """How often the block is inserted."""

    def __add__(self, other: Size) -> Size:
        return Size(min(self.own + other.own, CEILING), min(self.x + other.x, CEILING))

    def of(self, block: Size) -> Size:
        """Return the size when the block itself is a function of an outer block."""
        return Size(min(self.own + self.x * block.own, CEILING), min(self.x * block.x, CEILING))

    def most(self, other: Size) -> Size:
        """Return the larger of two alternatives."""
        return Size(max(self.own, other.own), max(self.x, other.x))


class ExpansionBound:
    """Counts, from above: conditions count as met, and one name's definitions as the largest.

    Args:
        included: The roots of the files that an include means; None if only
            expansion can tell.
    """

    def __init__(self, included: Callable[[Element], list[Element] | None]) -> None:
        self.included = included
        self.closed = True
        """Whether everything could be counted: no macro calls itself, no name is made up."""
        self.macros: dict[str, list[Element]] = {}
        self.blocks: dict[str, list[Element]] = {}
        self._known: dict[tuple[str, str], Size] = {}
        self._open: set[tuple[str, str]] = set()
        self._depth = 0

    def learn(self, root: Element) -> None:
        """Take in the macros and blocks that a file defines."""
        for element in root.everything():
            name = element.get("name", "")
            if element.tag == "xacro:macro":
                self.macros.setdefault(name.removeprefix("xacro:"), []).append(element)
            elif element.tag == "xacro:property" and len(element):
                self.blocks.setdefault(name, []).append(element)

    def check(self, root: Element, path: Path) -> None:
        """Count a description.

        Raises:
            RobotError: It would expand beyond `MOST_EXPANDED`; the element that
                does most of it is named.
        """
        sizes = [(self._element(child).own, child) for child in root.children()]
        total = sum(size for size, _ in sizes)
        if total > MOST_EXPANDED:
            _, worst = max(sizes, key=lambda pair: pair[0])
            count = f"{total}" if total < CEILING else f"more than {CEILING}"
            raise RobotError(
                f"<{worst.tag}> and the rest would expand to {count} elements; "
                f"{MOST_EXPANDED} are allowed",
                where=worst.place or str(path),
                fix="describe one robot: let macros call each other fewer times",
            )

    def _element(self, element: Element) -> Size:
        tag = element.tag
        if tag in ("xacro:macro", "xacro:property", "xacro:arg"):
            return Size()
        self._depth += 1
        try:
            if self._depth > DEEPEST_COUNT:
                self.closed = False
                return Size(1)
            return self._counted(element, tag)
        finally:
            self._depth -= 1

    def _counted(self, element: Element, tag: str) -> Size:
        if tag == "xacro:include":
            roots = self.included(element)
            if roots is None:
                self.closed = False
            return self._node("include", str(id(element)), roots or [])
        if tag == "xacro:insert_block":
            name = element.get("name", "")
            return Size(1, 1) + self._node("block", name, self.blocks.get(name, []))
        inside = self._children(element)
        if tag.startswith("xacro:") and tag not in ("xacro:if", "xacro:unless", "xacro:attribute"):
            name = tag.removeprefix("xacro:")
            # Names are made up by expansion here, so any macro may be meant.
            self.closed &= tag not in ("xacro:call", "xacro:element")
            bodies = self.macros.get(name) or self.macros.get(name.rpartition(".")[2], [])
            return self._node("macro", name, bodies).of(inside) + inside
        return Size(1) + inside

    def _children(self, element: Element) -> Size:
        size = Size()
        for child in element.children():
            size += self._element(child)
        return size

    def _node(self, kind: str, name: str, bodies: list[Element]) -> Size:
        """Return the size of what a name stands for."""
        key = (kind, name)
        if key in self._known:
            return self._known[key]
        if key in self._open:
            self.closed = False
            return Size()
        self._open.add(key)
        size = Size()
        for body in bodies:
            inner = self._children(body)
            size = size + inner if kind == "include" else size.most(inner)
        self._open.discard(key)
        self._known[key] = size + Size(1)
        return self._known[key]
