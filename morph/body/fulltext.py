"""An MjSpec as MJCF text from which every number comes back unchanged."""

from __future__ import annotations

import ctypes
import threading
from functools import cache
from pathlib import Path
from typing import Any

import mujoco

from morph.body.quiet import quiet
from morph.errors import RobotError

DIGITS = 17
"""Significant digits that tell any two doubles apart (IEEE 754)."""

_LOCK = threading.Lock()


def fulltext(spec: Any) -> str:
    """Return a compiled `mujoco.MjSpec` as MJCF text at full precision.

    MuJoCo writes six digits, too few for a mass that is checked to 1e-9. Its
    own tests raise the precision through a pair of private functions of the
    library, and so does this; the setting is put back afterwards.

    Raises:
        RobotError: This MuJoCo has no such functions.
    """
    library = _library()
    with _LOCK:
        before = library._mjPRIVATE__get_xml_precision()
        library._mjPRIVATE__set_xml_precision(DIGITS)
        try:
            # It compiles again, and would warn again.
            with quiet():
                text: str = spec.to_xml()
        finally:
            library._mjPRIVATE__set_xml_precision(before)
    return text


@cache
def _library() -> ctypes.CDLL:
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco*", "mujoco.dll"):
        for path in sorted(folder.glob(pattern)):
            library = ctypes.CDLL(str(path))
            if hasattr(library, "_mjPRIVATE__set_xml_precision"):
                return library
    raise RobotError(
        f"MuJoCo {mujoco.__version__} cannot write MJCF at full precision",
        where=str(folder),
        fix="install the MuJoCo version that pyproject.toml names",
    )
