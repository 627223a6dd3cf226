"""Console output: tables and paragraphs in its width, with control characters removed."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from io import StringIO

NARROWEST = 40
"""Columns; on a narrower terminal lines run over."""

BREAKS = " _-/\\.:,;"
"""Characters after which a long name may go on in the next line."""

ENDLESS = 1_000_000
"""Columns told to rich, which is to break no line: we have."""

TIE = "\N{NO-BREAK SPACE}"
"""A space at which no line ends."""

MOST_LETTERS = 1000
"""Longest name or sentence that is shown; JSON has it whole."""


def width() -> int | None:
    """Return the columns of the terminal; None where lines may be of any length.

    A pipe or a file has no width: there a name is never cut, so that it can be searched for.
    """
    given = os.environ.get("COLUMNS", "")
    if given.isdecimal() and 0 < int(given) < 100_000:
        return max(NARROWEST, int(given))
    if not sys.stdout.isatty():
        return None
    try:
        return max(NARROWEST, os.get_terminal_size(sys.stdout.fileno()).columns)
    except OSError:
        return 80


def say(lines: Iterable[tuple[str, str]]) -> None:
    """Write lines to the terminal, or to where output was led.

    Args:
        lines: Each a text and its style, such as `bold`; a pipe or a file gets no styles.
    """
    from rich.console import Console
    from rich.text import Text

    written = StringIO()
    # With a size of its own rich does not go by COLUMNS and LINES, at 0 of which it prints nothing.
    console = Console(
        file=written,
        force_terminal=sys.stdout.isatty(),
        soft_wrap=True,
        width=ENDLESS,
        height=1,
    )
    for text, style in lines:
        console.print(Text(text, style=style))
    # Written by us: rich would end the program itself where nobody reads any more.
    sys.stdout.write(written.getvalue())


def harmless(text: str, most: int = MOST_LETTERS) -> str:
    """Return a text with what moves a cursor, turns a line round or ends it written as escapes.

    Names come from strangers' files, and a terminal obeys what it is shown. What is
    longer than anyone reads is cut, and says so.
    """
    if len(text) > most:
        text = f"{text[:most]}... ({len(text)} letters)"
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter == TIE else ascii(letter)[1:-1] for letter in text
    )


def paragraph(text: str, indent: int, columns: int | None) -> list[str]:
    """Return a text's lines.

    Args:
        text: One line, with the spaces that it begins with; `TIE` where a space must
            not end a line.
        indent: Spaces before every further line.
        columns: The terminal's width; None: one line.
    """
    bare = text.lstrip(" ")
    first = len(text) - len(bare)
    if columns is None:
        return [text.replace(TIE, " ")]
    lines: list[str] = []
    for piece in broken(bare, columns - indent, columns - first):
        lines.append(" " * (indent if lines else first) + piece.replace(TIE, " "))
    return lines


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    columns: int | None,
    right: Sequence[str] = (),
) -> list[str]:
    """Return a table's lines, the head first; cells that are too wide go on below.

    Args:
        head: A title for each column; a column without a single entry is left out.
        rows: The cells.
        columns: The terminal's width; None: as wide as need be.
        right: Titles of columns whose cells end below each other.
    """
    kept = [at for at in range(len(head)) if any(row[at] for row in rows)]
    titles = [head[at] for at in kept]
    cut = [[row[at] for at in kept] for row in rows]
    whole = [max(map(cells, column)) for column in zip(titles, *cut, strict=True)]
    wide = whole if columns is None else _fitted(whole, titles, columns - 2 * (len(titles) - 1))
    lines = []
    for row in [titles, *cut]:
        parts = [list(broken(cell, size)) for cell, size in zip(row, wide, strict=True)]
        for at in range(max(map(len, parts))):
            shown = [
                _padded(part[at] if at < len(part) else "", size, title in right)
                for part, size, title in zip(parts, wide, titles, strict=True)
            ]
            lines.append("  ".join(shown).rstrip())
    return lines


def broken(text: str, size: int, first: int | None = None) -> Iterator[str]:
    """Yield a text in pieces, broken after a space, _, / or the like where that does not waste.

    Args:
        text: What is to be broken.
        size: Most columns of a piece.
        first: Most columns of the first piece, if they differ.
    """
    room = first or size
    while cells(text) > room:
        fits = 1
        while cells(text[: fits + 1]) <= room:
            fits += 1
        spaced = text.rfind(" ", 0, fits + 1) + 1
        near = max(text.rfind(letter, 0, fits) for letter in BREAKS) + 1
        at = next((end for end in (spaced, near) if end > fits // 3), fits)
        yield text[:at].rstrip(" ")
        text, room = text[at:].lstrip(" "), size
    yield text


def cells(text: str) -> int:
    """Return how many columns of a terminal a text takes: ideographs take two."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def _padded(text: str, size: int, right: bool) -> str:
    space = " " * (size - cells(text))
    return space + text if right else text + space


def _fitted(whole: Sequence[int], titles: Sequence[str], room: int) -> list[int]:
    """Return the columns' widths, the widest made narrower until all fit or none can give."""
    least = [max(8, max(map(cells, title.split()))) for title in titles]
    wide = list(whole)
    while sum(wide) > room:
        can = [at for at in range(len(wide)) if wide[at] > least[at]]
        if not can:
            break
        widest = max(can, key=lambda at: wide[at])
        wide[widest] -= 1
    return wide
