"""Isolation of the study from code that it calls: a module's import, a cell's function."""

from __future__ import annotations

import os
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

STDLIB = f"{os.path.realpath(sysconfig.get_path('stdlib'))}{os.sep}"
PACKAGES = {"site-packages", "dist-packages"}
"""Folder of the standard library, and names of folders of installed packages; bytecode of both is
used."""


@contextmanager
def isolated() -> Iterator[None]:
    """Restore what foreign code may change: stdout, the current folder, the process.

    Inside, stdout goes to stderr, and modules that are not installed are compiled from their
    source. A child process that leaves by this way (`os.fork`) ends here.
    """
    process, folder = os.getpid(), _current()
    finder = SourceFinder()
    sys.meta_path.insert(0, finder)
    status = 1
    try:
        with _stdout_to_stderr():
            yield
        status = 0
    finally:
        if os.getpid() != process:
            # Otherwise there would be two studies, or two answers for one cell.
            os._exit(status)
        with suppress(ValueError):
            sys.meta_path.remove(finder)
        if folder is not None:
            with suppress(OSError):
                os.chdir(folder)


class SourceLoader(SourceFileLoader):
    """Loader that compiles a module's source and reads no bytecode."""

    def get_code(self, fullname: str) -> CodeType:
        """Return the code of a module, compiled anew."""
        path = self.get_filename(fullname)
        code: CodeType = self.source_to_code(self.get_data(path), path)
        return code


class SourceFinder(MetaPathFinder):
    """Finder that leaves the search to the others and has project modules compiled anew.

    Python trusts bytecode whose source has the same size and the same second of modification,
    which may be older source than the one that was hashed.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec that the other finders give, with `SourceLoader` for projects."""
        others = [each for each in sys.meta_path if not isinstance(each, SourceFinder)]
        # As Python does, pass over finders of the old protocol, which have no `find_spec`.
        finders = (each.find_spec for each in others if hasattr(each, "find_spec"))
        specs = (find_spec(fullname, path, target) for find_spec in finders)
        spec = next((each for each in specs if each is not None), None)
        if spec is not None and type(spec.loader) is SourceFileLoader:
            file = os.path.realpath(spec.loader.path)
            if not file.startswith(STDLIB) and PACKAGES.isdisjoint(Path(file).parts):
                spec.loader = SourceLoader(spec.loader.name, spec.loader.path)
        return spec


def _current() -> str | None:
    """Return the current folder; None where it was deleted."""
    with suppress(OSError):
        return os.getcwd()
    return None


@contextmanager
def _stdout_to_stderr() -> Iterator[None]:
    """Redirect stdout of Python, C code and child processes to stderr."""
    saved = None
    with suppress(OSError):  # A process may have no streams.
        sys.stdout.flush()
        saved = os.dup(1)
        os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        if saved is not None:
            os.dup2(saved, 1)
            os.close(saved)
