"""A folder that is there whole or not at all."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path

from morph.errors import OutputError
from morph.make.reading import is_package

UNFINISHED, REPLACED = "unfinished", "replaced"
"""In the names of what stands beside a package while it is written, and after a kill."""


@contextmanager
def aside(folder: Path) -> Iterator[Path]:
    """Lend a folder to write into; it becomes `folder` if all went well, and else is gone.

    A package that was there before is replaced in one step and lost only then. A program that
    is killed leaves `.NAME.unfinished-...` beside it, which the next one sweeps away.

    Raises:
        OutputError: The place cannot be written to, or the disk is full.
    """
    check_out(folder)
    place = folder.absolute()
    made: Path | None = None
    lock: int | None = None
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        made, lock = _begun(place)
        yield made
        _swap(made, folder)
    except OSError as error:
        raise OutputError(
            f"cannot be written: {error.strerror or error}",
            where=str(folder),
            fix="choose a folder that can be written to and has room",
        ) from error
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)
        _let_go(lock)


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


def _begun(place: Path) -> tuple[Path, int | None]:
    """Return a new folder and the lock that says that it is being written to."""
    # In turn, or another program would sweep it away before it is locked.
    turn = _held(place.parent, wait=True)
    try:
        _sweep(place)
        made = _beside(place, UNFINISHED)
        made.chmod(0o755)
        return made, _held(made)
    finally:
        _let_go(turn)


def _beside(place: Path, what: str) -> Path:
    # A long name would leave no room for what is added: names have at most 255 bytes.
    return Path(tempfile.mkdtemp(dir=place.parent, prefix=f"{_prefix(place, what)}-"))


def _prefix(place: Path, what: str) -> str:
    return f".{place.name[:40]}.{what}"


def _held(folder: Path, *, wait: bool = False) -> int | None:
    """Return a lock on a folder that ends with this program, however it ends; None if not got."""
    lock = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        # Another program holds it, or this file system has no locks; nothing depends on it.
        os.close(lock)
        return None
    return lock


def _let_go(lock: int | None) -> None:
    if lock is not None:
        os.close(lock)


def _sweep(place: Path) -> None:
    """Remove what programs that were killed left here: nobody holds its lock any more."""
    for left in sorted(place.parent.glob(f"{escape(_prefix(place, UNFINISHED))}-*")):
        with suppress(OSError):
            lock = _held(left)
            if lock is not None:
                shutil.rmtree(left, ignore_errors=True)
            _let_go(lock)


def _swap(made: Path, folder: Path) -> None:
    """Put what was made into its place, one program after the other."""
    place = folder.absolute()
    turn = _held(place.parent, wait=True)
    try:
        # It took minutes to make: something else may stand here by now.
        check_out(folder)
        if not place.exists():
            os.rename(made, place)
            return
        old = _beside(place, REPLACED)
        os.rename(place, old / "package")
        try:
            os.rename(made, place)
        except OSError:
            os.rename(old / "package", place)
            raise
        finally:
            shutil.rmtree(old, ignore_errors=True)
    finally:
        _let_go(turn)
