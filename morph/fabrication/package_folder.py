"""Check and atomic replacement of the folder of a package."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from morph.atomic_directory import atomic_directory
from morph.errors import OutputError
from morph.fabrication.packed import FILE
from morph.fabrication.reading import is_package
from morph.files import write_whole
from morph.regular_file import read_regular
from morph.run_folder import OWNED

FOLDERS = ("parts", "refused", "gauges", "bought", "plates", "robot", "designed", "policy")
"""Folders of a package, which are replaced whole."""

CONTENT = (*FOLDERS, "bom.csv", "assembly.html", "report.html", FILE)
"""Names in the folder of a package; everything else there is the user's and stays."""

MAX_OWNED = 8 * 2**20
"""Most bytes of the list of a package's files."""


@contextmanager
def package_folder(folder: Path) -> Iterator[Path]:
    """Lend a temporary folder that becomes `folder` if all went well; the user's files stay.

    Raises:
        OutputError: The place cannot be written to, or the disk is full.
    """
    with atomic_directory(folder, check_out, (*CONTENT, OWNED)) as made:
        yield made
        files = sorted(each.relative_to(made).as_posix() for each in _files(made))
        write_whole(made / OWNED, json.dumps(files))


def check_out(folder: Path) -> None:
    """Refuse a place that no package may be written to, before the work is done.

    Raises:
        OutputError: It is a file, a link, the current folder, or a folder that holds something
            else.
    """
    try:
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise OutputError(
                "this is no folder", where=str(folder), fix="name a new or an empty folder"
            )
        if folder.is_dir() and folder.samefile(Path()):
            raise OutputError(
                "this is the current folder, and a package replaces its folder whole",
                where=str(folder),
                fix="name a folder in it, or run the command from elsewhere",
            )
        if folder.is_dir() and any(folder.iterdir()):
            _check_earlier(folder)
        parent = next(each for each in folder.absolute().parents if each.is_dir())
        if not os.access(parent, os.W_OK):
            raise OutputError(
                f"nothing can be written to {parent}",
                where=str(folder),
                fix="choose a folder that can be written to",
            )
    except OSError as error:
        raise OutputError(
            f"cannot be read: {error.strerror or error}",
            where=str(folder),
            fix="choose a folder that can be written to",
        ) from error


def _check_earlier(folder: Path) -> None:
    """Refuse a folder that is no earlier package, or that has the user's files in its folders."""
    if not is_package(folder):
        raise OutputError(
            "the folder is not empty and holds no earlier package",
            where=str(folder),
            fix="name a new or an empty folder, or one that `morph print` wrote",
        )
    present = [path for name in FOLDERS for path in _files(folder / name)]
    if present:
        written = _written(folder / OWNED)
        for path in present:
            if path.relative_to(folder).as_posix() not in written:
                raise OutputError(
                    "this is not of the earlier package, and would be deleted with it",
                    where=str(path),
                    fix="move it elsewhere, or name a new folder",
                )


def _written(path: Path) -> set[str]:
    """Return the files of a package, relative to its folder, from its list.

    Raises:
        OutputError: The list is missing or damaged.
    """
    try:
        return set(json.loads(read_regular(path, MAX_OWNED)))
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise OutputError(
            "the list of the package's files is missing or damaged, so yours cannot be told apart",
            where=str(path),
            fix="copy the package anew with its hidden files (cp -r DIR COPY), or print it into a "
            "new folder",
        ) from error


def _files(folder: Path) -> Iterator[Path]:
    """Yield everything in a folder that is no folder itself, links and pipes too."""
    return (each for each in sorted(folder.rglob("*")) if each.is_symlink() or not each.is_dir())
