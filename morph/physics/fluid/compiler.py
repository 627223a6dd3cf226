"""The C compilers of this machine, best first."""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import sys


def compilers() -> tuple[tuple[str, ...], ...]:
    """Return commands that compile C: `$CC`, those on the path, and ziglang if it is installed."""
    found = []
    if named := shlex.split(os.environ.get("CC", "")):
        found.append(tuple(named))
    found += [(name,) for name in ("cc", "gcc", "clang") if shutil.which(name)]
    if importlib.util.find_spec("ziglang") is not None:
        found.append((sys.executable, "-m", "ziglang", "cc"))
    return tuple(found)
