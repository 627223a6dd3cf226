"""Finding the files that a description names, inside its own folder and nowhere else."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath

from morph.regular_file import open_regular

MARKS = ("package.xml", "manifest.xml", "model.config", "card.toml", "CMakeLists.txt")
"""Files that mark a description's outermost folder."""

INNER = ("urdf", "robots", "robot", "xacro", "mjcf", "urdfs", "model", "models", "xml", "scenes")
"""Folders that hold descriptions beside the folder of their meshes."""

LONGEST = 1000
"""Longest path looked for, characters; systems stop at 255 for a name and 4096 in all."""

MOST_MARK = 65_536
"""Most of a package's manifest that is read, bytes; its name stands near its top."""

MOST_FILES = 20_000
"""Most files looked at in a folder; more is not a robot's folder but a disk."""

FEWEST_PARTS = 2
"""Parts of a path, with the root, up to which a folder holds more than one person's files."""

MOST_ALIKE = 200
"""Most files of one name looked at for each path."""


@dataclass(frozen=True, kw_only=True)
class ResolvedPath:
    """What became of a path."""

    path: Path | None
    """The file; None if there is none, or it must not be read."""
    how: str
    """`exact`, `package` (its package is this folder), `case`, `moved`, `missing` or `outside`."""
    outer: Path | None = None
    """Of what lies outside: the nearest folder that holds it and the description's."""

    @property
    def fix(self) -> str:
        """What helps where there is no file that may be read."""
        if self.outer is None:
            return "put the file there, correct its name, or give --folder one that holds both"
        return f"let all of {self.outer} be read: --folder {self.outer}"


def own_folder(description: Path) -> Path:
    """Return the outermost folder that belongs to a description.

    That is the nearest folder above it with a mark of a package; without one,
    the folder of the file, or the one above if it is called `urdf`, `robots`
    or the like.
    """
    start = description.resolve().parent
    for folder in (start, *list(start.parents)[:3]):
        if any((folder / mark).is_file() for mark in MARKS):
            return folder
    return start.parent if start.name.lower() in INNER else start


class Files:
    """The files of one description, indexed once when first needed."""

    def __init__(self, description: Path, folder: Path | None = None) -> None:
        self.beside = description.resolve().parent
        self.folder = (folder or own_folder(description)).resolve()

    def find(self, written: str, inner: str = "") -> ResolvedPath:
        """Return the file that a description means.

        Args:
            written: The path as the description writes it, with any scheme.
            inner: A folder that relative paths start from, such as MJCF's meshdir.
        """
        scheme, rest = _parts(written)
        if "\0" in rest or not rest.strip("/. ") or len(rest) > LONGEST:
            return ResolvedPath(path=None, how="missing")
        if scheme in ("", "file"):
            plain = Path(os.path.normpath(self.beside / inner / rest))
        elif rest.partition("/")[0] in self.packages:
            plain = Path(os.path.normpath(self.folder / rest.partition("/")[2]))
        else:
            plain = None
        if plain is not None and self._mine(plain) and plain.is_file():
            return ResolvedPath(path=plain, how="exact")
        near = self._search(PurePosixPath(rest), scheme not in ("", "file"))
        if near.path is None and plain is not None and not self._stays(plain):
            outer = Path(os.path.commonpath([self.folder, os.path.realpath(plain)]))
            # A description may name any file: nobody is told to let the whole disk be read.
            small = len(outer.parts) > FEWEST_PARTS
            return ResolvedPath(path=None, how="outside", outer=outer if small else None)
        return near

    @cached_property
    def packages(self) -> frozenset[str]:
        """The names by which descriptions may call this folder."""
        names = {self.folder.name}
        for mark in ("package.xml", "manifest.xml"):
            path = self.folder / mark
            # What a link leads to outside is not ours, and a pipe would be waited for.
            if not (self._mine(path) and path.is_file()):
                continue
            try:
                with open_regular(path) as file:
                    content = file.read(MOST_MARK)
                if b"<!" not in content.replace(b"<!--", b""):
                    result = ElementTree.fromstring(content).findtext("name")
                    names.add((result or "").strip())
            except (OSError, ElementTree.ParseError):
                continue
        return frozenset(names - {""})

    @cached_property
    def _index(self) -> dict[str, list[Path]]:
        index: dict[str, list[Path]] = {}
        count = 0
        for folder, folders, names in os.walk(self.folder):
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            for name in sorted(names):
                index.setdefault(name.lower(), []).append(Path(folder) / name)
                count += 1
            if count > MOST_FILES:
                break
        return index

    def _search(self, wanted: PurePosixPath, package: bool) -> ResolvedPath:
        best: tuple[int, int, int] | None = None
        chosen: Path | None = None
        for path in self._index.get(wanted.name.lower(), [])[:MOST_ALIKE]:
            relative = path.relative_to(self.folder)
            alike, exact = _common(wanted.parts, relative.parts)
            rank = (alike, exact, -len(relative.parts))
            if (best is None or rank > best) and self._mine(path) and path.is_file():
                best, chosen = rank, path
        if best is None or chosen is None:
            return ResolvedPath(path=None, how="missing")
        alike, exact, _ = best
        if exact < alike:
            return ResolvedPath(path=chosen, how="case")
        whole = package and self._holds(wanted.parts, chosen.relative_to(self.folder).parts, alike)
        return ResolvedPath(path=chosen, how="package" if whole else "moved")

    def _holds(self, wanted: tuple[str, ...], there: tuple[str, ...], alike: int) -> bool:
        """Return whether a path is right in a package of which this folder is all or a part."""
        before, above = wanted[: len(wanted) - alike], there[: len(there) - alike]
        # The folder may bear another name than its package, or than its place deep inside it;
        # a file's name alone says nothing of where it should be.
        return not before or (not above and (len(before) == 1 or alike > 1))

    def _within(self, path: Path) -> bool:
        return path == self.folder or self.folder in path.parents

    def _stays(self, path: Path) -> bool:
        try:
            return self._within(path) and self._within(path.resolve())
        except (OSError, RuntimeError):
            return False

    def _mine(self, path: Path) -> bool:
        # A link may lead anywhere; only its end counts.
        try:
            return self._within(path) and self._within(path.resolve(strict=True))
        except (OSError, RuntimeError):
            return False


def _parts(written: str) -> tuple[str, str]:
    text = written.strip().replace("\\", "/")
    scheme, mark, rest = text.partition("://")
    if not mark:
        return "", text
    return scheme.lower(), rest


def _common(wanted: tuple[str, ...], there: tuple[str, ...]) -> tuple[int, int]:
    """Return how many last parts agree, and how many agree in their capitals too."""
    alike = exact = 0
    for one, other in zip(reversed(wanted), reversed(there), strict=False):
        if one.lower() != other.lower():
            break
        alike += 1
        exact += one == other
    return alike, exact
