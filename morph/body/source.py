"""The text of a description, within bounds and with its macros expanded."""

from __future__ import annotations

from pathlib import Path

from morph.body.paths import Files
from morph.body.xml import MOST_BYTES, Element, parse
from morph.errors import RobotError
from morph.regular_file import read_regular


def source_tree(path: Path, files: Files) -> Element:
    """Return the XML of a description; of xacro, what it expands to.

    Raises:
        RobotError: It cannot be read, is no XML within bounds, or does not expand.
    """
    tree = parse(read_text(path), str(path))
    # Macros in a file that calls itself URDF count only if there is nothing else.
    macros = any(child.tag.startswith("xacro:") for child in tree.children())
    if path.suffix.lower() == ".xacro" or (macros and tree.child("link") is None):
        from morph.body.xacro import read

        tree = read(path, files.folder)
    return tree


def read_text(path: Path) -> bytes:
    """Return a description's bytes.

    Raises:
        RobotError: The file cannot be read, is no regular file, or is too large.
    """
    try:
        return read_regular(path, MOST_BYTES)
    except (OSError, ValueError) as error:
        raise RobotError(
            f"cannot be read: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="give the file of a description, with its shapes in mesh files, or a name that "
            "`morph list robots` shows",
        ) from error
