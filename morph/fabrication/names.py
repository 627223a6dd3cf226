"""Names and numbers of parts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import PurePosixPath

SIDES = {"left", "right", "l", "r", "front", "rear", "back", "fl", "fr", "rl", "rr"}
"""Words that say which copy it is, and not what."""


def safe(text: str) -> str:
    """Return a text as a name: lower case, digits and underscores, at most 60 letters."""
    words = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    return words[:60].strip("_") or "part"


def of_file(file: str) -> str:
    """Return the name of what a mesh file holds; the importer numbers files, and that is cut."""
    return safe(re.sub(r"^\d+_(?=.)", "", PurePosixPath(file).stem))


def shared(links: Sequence[str]) -> str:
    """Return what the names of several links have in common, without sides."""
    if len(set(links)) == 1:
        return safe(links[0])
    split = [safe(link).split("_") for link in links]
    words = [word for word in split[0] if all(word in others for others in split)]
    kept = [word for word in words if word not in SIDES]
    return "_".join(kept or words or split[0])


class UniqueNames:
    """Gives each name once."""

    def __init__(self) -> None:
        self.taken: set[str] = set()

    def one(self, wanted: str) -> str:
        """Return a name, with a number behind it if it is taken."""
        name, number = wanted, 1
        while name in self.taken:
            number += 1
            name = f"{wanted}_{number}"
        self.taken.add(name)
        return name


def sided(names: Iterable[str]) -> str:
    """Return the side that all names say, `left` or `right`; empty if they do not agree."""
    labels = set()
    for name in names:
        words = set(safe(name).split("_"))
        labels.add("left" if words & {"left", "l"} else "right" if words & {"right", "r"} else "")
    return labels.pop() if len(labels) == 1 else ""
