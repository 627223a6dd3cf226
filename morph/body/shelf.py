"""Where bodies live: the built-in shelf, and a shelf of one's own."""

from __future__ import annotations

import difflib
import os
import sys
from pathlib import Path

import morph
from morph.errors import RobotError

LONGEST = 100
"""Letters of a name that are compared and told."""


def builtin_shelf() -> Path:
    """Return the folder of the bodies that come with morph.

    In a checkout `morph/robots` is a link to the folder `robots`.
    """
    return (Path(morph.__file__).parent / "robots").resolve()


def user_shelf() -> Path:
    """Return the folder of the user's own bodies; it need not exist.

    `$MORPH_SHELF` names it; by default it lies in the platform's data folder.
    """
    if chosen := os.environ.get("MORPH_SHELF"):
        return Path(chosen)
    if sys.platform == "darwin":
        data = Path.home() / "Library" / "Application Support"
    elif sys.platform == "win32":
        data = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    else:
        data = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return data / "morph" / "robots"


def names() -> tuple[str, ...]:
    """Return the names of all bodies on both shelves, in alphabetical order."""
    return tuple(sorted(_folders()))


def find(name: str) -> Path:
    """Return the folder of a body; the user's own comes before a built-in one.

    Raises:
        RobotError: Neither shelf has a body of this name.
    """
    folders = _folders()
    if name in folders:
        return folders[name]
    nearest = difflib.get_close_matches(name[:LONGEST], folders, n=3, cutoff=0.4)
    like = f"nearest: {', '.join(nearest)}" if nearest else f"none of {len(folders)} is like it"
    shown = name if len(name) <= LONGEST else f"{name[:LONGEST]}..."
    raise RobotError(
        f"no robot is called {shown!r}; {like}",
        where=f"the shelves {builtin_shelf()} and {user_shelf()}",
        fix="`morph list robots` shows all; or give the path of a description or its folder",
    )


def _folders() -> dict[str, Path]:
    return {
        card.parent.name: card.parent
        for shelf in (builtin_shelf(), user_shelf())
        for card in sorted(shelf.glob("*/card.toml"))
    }
