"""Figures that were computed once, kept by the content of what they were computed from."""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Callable, Mapping

import numpy as np

from morph.arrays import Array
from morph.body.pieces import cache_folder
from morph.errors import MorphError
from morph.files import sha256, write_whole

EDITION = "5"
"""Part of every key; raised when the same shapes and settings come to give other figures."""

Values = Mapping[str, Array | float | str]


def kept(parts: tuple[bytes | str, ...], compute: Callable[[], Values]) -> dict[str, Array]:
    """Return named values from the cache, computed first if they are not there.

    Args:
        parts: All that the values depend on; their bytes are the key.
        compute: Computes them; what it raises goes through.
    """
    path = cache_folder() / "fluid" / f"{sha256(EDITION, *parts)}.npz"
    found = _stored(path.read_bytes) if path.is_file() else None
    if found is None:
        data = _packed(compute())
        # A cache that cannot be written to costs time, not the result.
        with contextlib.suppress(MorphError):
            write_whole(path, data)
        found = _stored(lambda: data) or {}
    return found


def _packed(values: Values) -> bytes:
    sink = io.BytesIO()
    arrays = {name: np.asarray(value) for name, value in values.items()}
    np.savez(sink, allow_pickle=False, **arrays)
    return sink.getvalue()


def _stored(read: Callable[[], bytes]) -> dict[str, Array] | None:
    """Return the values in a file of the cache, or None if it is damaged."""
    try:
        with np.load(io.BytesIO(read()), allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None
