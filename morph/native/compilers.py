"""The C compilers of this machine, best first, and what its processor can do."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import platform
import shlex
import shutil
import sys
from pathlib import Path


def compilers() -> tuple[tuple[str, ...], ...]:
    """Return commands that compile C: `$CC`, those on the path, and ziglang if it is installed."""
    results = []
    # A quotation that is not closed names no compiler; the others are still there.
    with contextlib.suppress(ValueError):
        if named := shlex.split(os.environ.get("CC", "")):
            results.append(tuple(named))
    results += [(name,) for name in ("cc", "gcc", "clang") if shutil.which(name)]
    if importlib.util.find_spec("ziglang") is not None:
        results.append((sys.executable, "-m", "ziglang", "cc"))
    return tuple(results)


def processor() -> str:
    """Return what tells one kind of processor from another."""
    try:
        lines = Path("/proc/cpuinfo").read_text(errors="replace").splitlines()
    except OSError:
        return platform.processor()
    # What it can do; the other lines hold speeds, which change by themselves.
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")
