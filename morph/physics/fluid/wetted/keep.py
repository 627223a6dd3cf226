"""Figures that were computed once, kept by the content of what they were computed from."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.body.pieces import cache_folder
from morph.errors import MorphError
from morph.files import sha256, write_whole
from morph.npz import load_npz

EDITION = "5"
"""Part of every key; raised when the same shapes and settings come to give other figures."""

MOST_STORED = 2**26
"""Most bytes of what is kept of one body; a hull and its tables have some hundred thousand."""

Values = Mapping[str, Array | float | str]


def kept(parts: tuple[bytes | str, ...], compute: Callable[[], Values]) -> dict[str, Array]:
    """Return named values from the cache, computed first if they are not there.

    Args:
        parts: All that the values depend on; their bytes are the key.
        compute: Computes them; what it raises goes through.
    """
    path = cache_folder() / "fluid" / f"{sha256(EDITION, *parts)}.npz"
    result = _stored(path)
    if result is None:
        data = _packed(compute())
        # A cache that cannot be written to costs time, not the result.
        with contextlib.suppress(MorphError):
            write_whole(path, data)
        result = _stored(data) or {}
    return result


def _packed(values: Values) -> bytes:
    sink = io.BytesIO()
    arrays = {name: np.asarray(value) for name, value in values.items()}
    np.savez(sink, allow_pickle=False, **arrays)
    return sink.getvalue()


def _stored(source: Path | bytes) -> dict[str, Array] | None:
    """Return the values in a file of the cache, or None if there is none, or a damaged one."""
    try:
        return load_npz(source, MOST_STORED)
    except (OSError, ValueError):
        return None
