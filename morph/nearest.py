"""What a reader may have meant by a name that is not known."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, known: Iterable[str], *, most: int = 3) -> str:
    """Return the known names closest to a name, for the fix of an error.

    All are returned when there are no more than `most`, or when none is close.
    """
    names = sorted(set(known))
    close = difflib.get_close_matches(name, names, n=most, cutoff=0.5)
    return ", ".join(repr(one) for one in close or names) or "none"
