"""A folder that is there whole or not at all: written beside its place, then renamed."""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from glob import escape
from pathlib import Path

from morph.errors import OutputError

UNFINISHED, REPLACED = "unfinished", "replaced"
"""In the names of what stands beside a folder while it is written, and after a kill."""

OLD = "old"
"""The name of a folder within the one that it is moved into, while it is replaced."""

MAX_NAME = 40
"""Characters of a folder's name in the names of what stands beside it."""

AT_FDCWD, RENAME_EXCHANGE = -100, 2
"""Numbers of Linux's renameat2(2)."""


@contextmanager
def atomic_directory(
    folder: Path, check: Callable[[Path], None], ours: Collection[str] | None = None
) -> Iterator[Path]:
    """Lend a folder to write into; it becomes `folder` if all went well, and else is gone.

    What was there before is replaced in one step, and lost only then. A program that is killed
    leaves `.NAME.unfinished-...` beside it, which the next one sweeps away.

    Args:
        folder: The place.
        check: Refuses a place that must not be replaced by an `OutputError`.
        ours: Names in an earlier folder that are replaced; all others are taken over into the new
            one. None: all are replaced.

    Raises:
        OutputError: The place cannot be written to, or the disk is full.
    """
    check(folder)
    place = folder.absolute()
    made: Path | None = None
    lock: int | None = None
    try:
        _check_home(place)
        place.parent.mkdir(parents=True, exist_ok=True)
        made, lock = _begun(place, ours)
        yield made
        _swap(made, folder, check, ours)
    except OSError as error:
        raise OutputError(
            f"cannot be written: {error.strerror or error}",
            where=str(folder),
            fix="choose a folder that can be written to and has room",
        ) from error
    finally:
        if made is not None:
            _discard(made, place, ours)
        _let_go(lock)


def _check_home(place: Path) -> None:
    """Refuse the folder in which all that a user has lies, whatever it holds of ours."""
    with suppress(RuntimeError):
        if Path.home().resolve().is_relative_to(place.resolve()):
            raise OutputError(
                "your home lies in this folder, and it would be replaced whole",
                where=str(place),
                fix="name a new folder in it",
            )


def _begun(place: Path, ours: Collection[str] | None) -> tuple[Path, int | None]:
    """Return a new folder and the lock that says that it is being written to."""
    # In turn, or another program would sweep it away before it is locked.
    turn = _held(place.parent, wait=True)
    try:
        _sweep(place, ours)
        made = _beside(place, UNFINISHED)
        made.chmod(0o755)
        return made, _held(made)
    finally:
        _let_go(turn)


def _beside(place: Path, what: str) -> Path:
    # A long name would leave no room for what is added: names have at most 255 bytes.
    return Path(tempfile.mkdtemp(dir=place.parent, prefix=f"{_prefix(place, what)}-"))


def _prefix(place: Path, what: str) -> str:
    if len(place.name) <= MAX_NAME:
        return f".{place.name}.{what}"
    # Two long names may begin alike: what is left of one must never be taken for the other's.
    mark = hashlib.sha256(os.fsencode(place.name)).hexdigest()[:8]
    return f".{place.name[:MAX_NAME]}.{mark}.{what}"


def _held(folder: Path, *, wait: bool = False) -> int | None:
    """Return a lock on a folder that ends with this program, however it ends; None if not got."""
    lock = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
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


def _sweep(place: Path, ours: Collection[str] | None) -> None:
    """Put right what programs that were killed left here: nobody holds its lock any more."""
    for left in sorted(place.parent.glob(f"{escape(_prefix(place, REPLACED))}-*")):
        with suppress(OSError):
            if not place.exists() and (left / OLD).is_dir():
                # It was killed between the two renames.
                os.rename(left / OLD, place)
            _discard(left / OLD, place, ours)
            left.rmdir()
    for left in sorted(place.parent.glob(f"{escape(_prefix(place, UNFINISHED))}-*")):
        with suppress(OSError):
            lock = _held(left)
            if lock is not None:
                _discard(left, place, ours)
            _let_go(lock)


def _discard(left: Path, place: Path, ours: Collection[str] | None) -> None:
    """Remove a folder, once what is not ours in it has been taken over."""
    if not left.is_dir():
        return
    with suppress(OSError):
        for each in sorted(left.iterdir()):
            if ours is not None and each.name not in ours:
                # Never over another, and never removed: somebody wrote it.
                if os.path.lexists(place / each.name):
                    return
                os.rename(each, place / each.name)
        shutil.rmtree(left, ignore_errors=True)


def _swap(
    made: Path, folder: Path, check: Callable[[Path], None], ours: Collection[str] | None
) -> None:
    """Put what was made into its place, one program after the other."""
    place = folder.absolute()
    turn = _held(place.parent, wait=True)
    try:
        # It took minutes to make: something else may stand here by now.
        check(folder)
        if not place.exists():
            os.rename(made, place)
        elif not _exchanged(made, place):
            old = _beside(place, REPLACED)
            os.rename(place, old / OLD)
            try:
                os.rename(made, place)
            except OSError:
                os.rename(old / OLD, place)
                raise
            finally:
                _discard(old / OLD, place, ours)
                with suppress(OSError):
                    old.rmdir()
    finally:
        _let_go(turn)


def _exchanged(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; return whether this system can."""
    renameat2 = getattr(ctypes.CDLL(None), "renameat2", None)
    if renameat2 is None:
        return False
    paths = [ctypes.c_char_p(os.fsencode(each)) for each in (one, other)]
    ended: int = renameat2(AT_FDCWD, paths[0], AT_FDCWD, paths[1], ctypes.c_uint(RENAME_EXCHANGE))
    return ended == 0
