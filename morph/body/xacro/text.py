"""What stands between `${` and `}` and between `$(` and `)` in the texts of xacro."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Literal

from morph.errors import RobotError

Kind = Literal["text", "expression", "command"]

TOKEN = re.compile(
    r"(?P<escape>\$\$+[{(])|\$\{(?P<expression>[^}]*)\}|\$\((?P<command>[^)]*)\)"
    r"|(?P<text>[^$]+|\$[^{($]+|\$$)"
)
"""The pieces that xacro (2.1, `LEXER`) tells apart, in its order."""


def tokens(text: str, where: str) -> Iterator[tuple[Kind, str]]:
    """Yield the pieces of a text.

    Raises:
        RobotError: A bracket after `$` is never closed.
    """
    position = 0
    while position < len(text):
        match = TOKEN.match(text, position)
        if match is None:
            raise RobotError(
                f"has a dollar sign at {text[position : position + 40]!r} that opens no "
                "bracket, or one that is not closed",
                where=where,
                fix="close the bracket, or write $$ for a dollar sign",
            )
        position = match.end()
        if match["expression"] is not None:
            yield "expression", match["expression"]
        elif match["command"] is not None:
            yield "command", match["command"]
        else:
            # Of several dollar signs before a bracket, the first only marks the others as text.
            yield "text", match["text"] or match["escape"][1:]
