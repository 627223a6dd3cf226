"""Numbers from text."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from morph.arrays import Array, Integers


def floats(text: str | None) -> Array:
    """Return the numbers in a text, with white space between them.

    Raises:
        ValueError: Something in it is no number.
    """
    result: Array = _read(text, np.float64)
    return result


def integers(text: str | None) -> Integers:
    """Return the whole numbers in a text, with white space between them.

    Raises:
        ValueError: Something in it is no whole number.
    """
    result: Integers = _read(text, np.int64)
    return result


def _read(text: str | None, kind: type[np.generic]) -> Any:
    if not text or not text.strip():
        return np.zeros(0, dtype=kind)
    # To split a text of 30 MiB into words would take a gigabyte.
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except DeprecationWarning as warning:
            raise ValueError("a list of numbers holds something else") from warning
