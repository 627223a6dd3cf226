"""The files that a xacro description may read: those of its own folder, and no others."""

from __future__ import annotations

import fnmatch
import os
import re
from functools import cached_property
from pathlib import Path, PurePosixPath

from morph.body.paths import Files
from morph.body.xml import MOST_BYTES
from morph.errors import RobotError
from morph.regular_file import read_regular

MOST_ENTRIES = 20_000
"""Most files and folders looked at in a search; more is not a robot's folder but a disk."""

PATTERN = re.compile(r"[*?\[]")
"""What makes a name a pattern, for xacro as for a shell."""

KEEP_INSIDE = "keep all that the description includes in its own folder, and name that folder"


class Folder:
    """A description's own folder.

    Args:
        root: The folder; links in its own path are followed, once, here.
    """

    def __init__(self, root: Path) -> None:
        self.root = Path(os.path.realpath(root))

    def inside(self, path: Path, where: str) -> Path:
        """Return a path with all links followed.

        Raises:
            RobotError: It leads out of the folder, by its letters or by a link.
        """
        plain = Path(os.path.normpath(path))
        # By its letters first: what lies outside is not even looked at.
        if self._holds(plain):
            try:
                real = Path(os.path.realpath(plain))
            except (OSError, ValueError) as error:
                raise _unusable(str(path), str(error), where) from error
            if self._holds(real):
                return real
        raise RobotError(
            f"reads {str(path)!r}, which leads out of {str(self.root)!r}",
            where=where,
            fix=KEEP_INSIDE,
        )

    def matches(self, written: str, beside: Path, where: str) -> list[Path]:
        """Return the files that an include or a `load_yaml` means, in order.

        A file that is not there comes back as its path, for the reader to miss.

        Args:
            written: A path from the root or from `beside`, or a pattern of the shell.
            beside: The folder of the file that says so.
            where: That file and the line.

        Raises:
            RobotError: It leads out of the folder.
        """
        if "\0" in written or not written.strip():
            raise _unusable(written, "it is no name of a file", where)
        whole = Path(os.path.join(beside, written))
        if not PATTERN.search(written):
            return [self._near(self.inside(whole, where), where)]
        parts = whole.parts
        first = next(index for index, part in enumerate(parts) if PATTERN.search(part))
        start = self.inside(Path(*parts[:first]), where)
        if ".." in parts[first:]:
            raise _unusable(written, "a pattern may not climb", where)
        pattern = (*start.relative_to(self.root).parts, *parts[first:])
        return [
            self.inside(self.root / entry, where)
            for entry in self._entries
            if len(entry.parts) == len(pattern)
            and all(map(fnmatch.fnmatchcase, entry.parts, pattern))
        ]

    def package(self, name: str, where: str) -> Path:
        """Return the folder that `$(find name)` means; one that is not there if none is called so.

        Raises:
            RobotError: That is no name of a package.
        """
        if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.\-]*", name):
            raise _unusable(name, "it is no name of a package", where)
        if self._named(self.root) == name:
            return self.root
        called = [self.root / entry for entry in self._entries if entry.name == name]
        called = [path for path in called if path.is_dir() and not path.is_symlink()]
        marked = [self.root / entry for entry in self._entries if entry.name == "package.xml"]
        for folder in (*called, *(path.parent for path in marked[:100])):
            if self._named(folder) == name:
                return folder
        if self.root.name == name:
            return self.root
        return called[0] if called else self.root / name

    def read(self, path: Path, where: str) -> bytes:
        """Return the content of a file of the folder.

        Raises:
            FileNotFoundError: It is not there.
            RobotError: It leads out, is no regular file, or is longer than any description.
        """
        real = self.inside(path, where)
        try:
            # All links were followed; one that is put here now may lead anywhere.
            return read_regular(real, MOST_BYTES, follow=False)
        except FileNotFoundError:
            raise
        except (OSError, ValueError) as error:
            raise _unusable(str(path), str(error), where) from error

    def _near(self, path: Path, where: str) -> Path:
        """Return a path, or, if it is not there, the one file whose path ends as it does."""
        # Not Path.exists, which fails on a name that is too long for any file.
        if os.path.exists(path):
            return path
        relative = path.relative_to(self.root)
        try:
            result = Files(path, self.root).find(f"package://{relative}")
        except OSError as error:
            raise _unusable(str(relative), f"it is no file: {error.strerror}", where) from error
        if result.path is None or result.how == "case":
            return path
        return self.inside(result.path, where)

    def _holds(self, path: Path) -> bool:
        return path == self.root or self.root in path.parents

    @cached_property
    def _entries(self) -> list[PurePosixPath]:
        results: list[PurePosixPath] = []
        for folder, folders, names in os.walk(self.root):
            folders[:] = sorted(name for name in folders if not name.startswith("."))
            here = PurePosixPath(os.path.relpath(folder, self.root))
            results += [here / name for name in sorted((*folders, *names))]
            if len(results) > MOST_ENTRIES:
                break
        return results

    def _named(self, folder: Path) -> str:
        """Return the name in a folder's package.xml, or nothing."""
        try:
            content = self.read(folder / "package.xml", str(folder))[:65536]
        except (OSError, RobotError):
            return ""
        name = re.search(rb"<name>\s*([\w.\-]{1,200})\s*</name>", content)
        return name[1].decode(errors="replace") if name else ""


def _unusable(name: str, why: str, where: str) -> RobotError:
    shown = name if len(name) < 100 else name[:100] + "…"
    return RobotError(f"names {shown!r}, and {why}", where=where, fix=KEEP_INSIDE)
