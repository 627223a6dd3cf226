"""A folder that is there whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from morph.errors import OutputError
from morph.make.reading import is_package


@contextmanager
def aside(folder: Path) -> Iterator[Path]:
    """Lend a folder to write into; it becomes `folder` if all went well, and else is gone.

    A package that was there before is replaced in one step and lost only then.

    Raises:
        OutputError: The place cannot be written to, or the disk is full.
    """
    check_out(folder)
    place = folder.absolute()
    made: Path | None = None
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(dir=place.parent, prefix=f".{place.name}."))
        made.chmod(0o755)
        yield made
        _swap(made, place)
    except OSError as error:
        raise OutputError(
            f"cannot be written: {error.strerror or error}",
            where=str(folder),
            fix="choose a folder that can be written to and has room",
        ) from error
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)


def check_out(folder: Path) -> None:
    """Refuse a place that no package may be written to, before the work is done.

    Raises:
        OutputError: It is a file, a link, or a folder that holds something else.
    """
    try:
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise OutputError(
                "this is no folder", where=str(folder), fix="name a new or an empty folder"
            )
        if folder.is_dir() and any(folder.iterdir()) and not is_package(folder):
            raise OutputError(
                "the folder is not empty and holds no earlier package",
                where=str(folder),
                fix="name a new or an empty folder, or one that `morph print` wrote",
            )
        standing = next(each for each in folder.absolute().parents if each.is_dir())
        if not os.access(standing, os.W_OK):
            raise OutputError(
                f"nothing can be written to {standing}",
                where=str(folder),
                fix="choose a folder that can be written to",
            )
    except OSError as error:
        raise OutputError(
            f"cannot be looked at: {error.strerror or error}",
            where=str(folder),
            fix="choose a folder that can be written to",
        ) from error


def _swap(made: Path, place: Path) -> None:
    if not place.exists():
        os.rename(made, place)
        return
    old = Path(tempfile.mkdtemp(dir=place.parent, prefix=f".{place.name}.old."))
    os.rename(place, old / "package")
    try:
        os.rename(made, place)
    except OSError:
        os.rename(old / "package", place)
        raise
    finally:
        shutil.rmtree(old, ignore_errors=True)
