"""C libraries of this project: built once by the C compiler at hand, and kept by content."""

from __future__ import annotations

import contextlib
import ctypes
import itertools
import os
import platform
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from morph.body.pieces import cache_folder
from morph.errors import KernelError
from morph.files import sha256
from morph.native.compilers import compilers, processor
from morph.native.private import changed_by_others, make_private
from morph.regular_file import read_regular

FLAGS = ("-O3", "-fPIC", "-shared", "-std=c99")
NATIVE = ("-march=native",)
"""Lets the compiler use all that this processor has; left out where it does not know how."""


@contextmanager
def kept_folder() -> Iterator[Path]:
    """Give the folder of libraries in the cache, or a passing one if others could change that.

    Once a library is loaded its file is not needed.
    """
    folder = cache_folder() / "kernel"
    with contextlib.suppress(OSError):
        make_private(folder)
        if not changed_by_others(folder):
            yield folder
            return
    with tempfile.TemporaryDirectory(prefix="morph-") as passing:
        yield Path(passing)


def build(
    source: Path,
    folder: Path,
    *,
    name: str,
    headers: Sequence[Path] = (),
    include: Path | None = None,
) -> Path:
    """Return a compiled library, built first where a folder does not hold it yet.

    Its key is the content of the source and of the headers, and the processor: another machine
    that shares the folder builds its own.

    Args:
        source: The C file.
        folder: Where libraries are kept.
        name: What the library's file name begins with.
        headers: Headers of others that it depends on.
        include: The folder that they are included from.

    Raises:
        KernelError: There is no C compiler, or it fails, or the folder cannot be written to.
    """
    key = sha256(source, *headers, " ".join(FLAGS), platform.platform(), processor())
    path = folder / f"{name}-{key[:20]}.so"
    if not _sound(path):
        _compile(source, path, [] if include is None else [f"-I{include}"])
    return path


def load(path: Path, *, fix: str) -> ctypes.CDLL:
    """Return a library that nobody else could have put there.

    Raises:
        KernelError: It is no library, or may be somebody else's.
    """
    try:
        why = changed_by_others(path)
        if why:
            raise KernelError(
                f"is not loaded, as it may not be yours: {why}", where=str(path), fix=fix
            )
        # All links are followed, so that none can be turned after that look.
        return ctypes.CDLL(str(path.resolve()))
    except OSError as error:
        raise KernelError(f"is no library: {str(error)[:200]}", where=str(path), fix=fix) from error


def _sum_of(path: Path) -> Path:
    return path.with_suffix(".sha256")


def _sound(path: Path) -> bool:
    """Return whether a library is as it was built: one cut short would end this process."""
    try:
        return sha256(path) == read_regular(_sum_of(path), 100).decode()
    except (OSError, ValueError):
        return False


def _compile(source: Path, path: Path, more: Sequence[str]) -> None:
    """Try each compiler in turn; the library appears whole or not at all."""
    tried = []
    for compiler, extra in itertools.product(compilers(), (NATIVE, ())):
        try:
            make_private(path.parent)
            with tempfile.TemporaryDirectory(dir=path.parent) as folder:
                made = Path(folder) / path.name
                _run([*compiler, *FLAGS, *extra, *more, str(source), "-o", str(made), "-lm"])
                _sum_of(made).write_text(sha256(made))
                os.replace(_sum_of(made), _sum_of(path))
                os.replace(made, path)
        except (OSError, subprocess.SubprocessError) as error:
            tried.append(f"{' '.join(compiler)}: {str(error)[:200]}")
        else:
            return
    raise KernelError(
        "; ".join(tried) or "there is no C compiler",
        where=str(path),
        fix="install a C compiler, or `pip install ziglang`, which brings one",
    )


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    if done.returncode:
        raise subprocess.SubprocessError(done.stderr.strip() or f"status {done.returncode}")
