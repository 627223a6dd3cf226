"""Reading TOML files that a user names, within bounds."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from morph.regular_file import read_regular

MOST_DOTS = 1000
"""Most dots of a line: time to read a key grows with the square of its dots."""

MOST_SQUARED = 20_000_000
"""Most that the dots of all lines, squared, may add up to: so many take a second. 400 lines of 200
decimal fractions stay below."""


def load_toml(path: Path, most: int) -> tuple[dict[str, Any], str]:
    """Return the tables of a TOML file, and its text.

    Args:
        path: The file.
        most: Most bytes that it may have.

    Raises:
        OSError: It cannot be read, is no regular file, or has more bytes.
        ValueError: It is no TOML, no UTF-8, nests too deeply, or has keys of thousands of dots.
    """
    data = read_regular(path, most)
    dots = [line.count(b".") for line in data.split(b"\n")]
    if max(dots) > MOST_DOTS:
        most = dots.index(max(dots))
        raise ValueError(f"{dots[most]} dots, of which {MOST_DOTS} may be (at line {most + 1})")
    if sum(each**2 for each in dots) > MOST_SQUARED:
        raise ValueError("its keys have thousands of dots")
    text = data.decode("utf-8")
    try:
        return tomllib.loads(text), text
    except RecursionError as error:
        raise ValueError("it nests too deeply") from error
