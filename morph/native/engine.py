"""C libraries that call the MuJoCo of this process."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import mujoco

from morph.native import library


def build(source: Path, folder: Path, *, name: str) -> Path:
    """Return a compiled library that includes MuJoCo's headers, built first where it is missing.

    A new MuJoCo builds a new one: the headers are part of its key.

    Args:
        source: The C file.
        folder: Where libraries are kept.
        name: What the library's file name begins with.

    Raises:
        KernelError: There is no C compiler, or it fails, or the folder cannot be written to.
    """
    include = Path(mujoco.HEADERS_DIR).parent
    return library.build(
        source,
        folder,
        name=f"{name}-{mujoco.mj_version()}",
        headers=sorted(include.glob("mujoco/*.h")),
        include=include,
    )


def functions(names: Sequence[str]) -> list[ctypes.c_void_p]:
    """Return pointers to functions of MuJoCo's own library, which is loaded already."""
    folder = Path(mujoco.__file__).parent
    (path,) = [p for name in ("libmujoco*", "mujoco.dll") for p in folder.glob(name)]
    engine = ctypes.CDLL(str(path))
    return [ctypes.cast(getattr(engine, name), ctypes.c_void_p) for name in names]
