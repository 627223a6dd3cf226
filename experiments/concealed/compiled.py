"""`chain.c`, compiled once for each content and loaded."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from experiments.concealed.errors import CompilerError
from experiments.concealed.fields import header
from morph.native.compilers import compilers

SOURCE = Path(__file__).with_name("chain.c")
FLAGS = ("-O2", "-ffp-contract=off", "-fPIC", "-shared", "-std=c99", "-x", "c")
"""No fused operations and none of this processor alone: the same bytes on most machines."""


def pointer(array: np.ndarray) -> Any:
    """Return the address of an array, for the compiled functions."""
    return ctypes.c_void_p(array.ctypes.data)


@cache
def library() -> ctypes.CDLL:
    """Return the compiled dynamics of this process.

    It is compiled into a private folder that is removed at once, so no other user can change what
    is loaded; that takes half a second a process.

    Raises:
        CompilerError: There is no C compiler, or it refuses the source.
    """
    command = next(iter(compilers()), None)
    if command is None:
        raise CompilerError(
            "there is no C compiler",
            where="PATH",
            fix="install a C compiler, or `pip install ziglang`, which brings one",
        )
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "chain.so"
        done = subprocess.run(
            [*command, *FLAGS, "-", "-o", str(target), "-lm"],
            input=header() + SOURCE.read_text(),
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            raise CompilerError(
                f"{command[0]} failed: {done.stderr.strip()[:500]}",
                where=str(SOURCE),
                fix="name another C compiler by CC",
            )
        return ctypes.CDLL(str(target))
