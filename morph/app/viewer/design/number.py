"""The number that the page knows a control by."""

from __future__ import annotations

from typing import Any


def number_of(handle: Any) -> str:
    """Return the number that stands in the page's label of one of viser's controls."""
    # viser keeps it to itself, though its client writes it into the page as `for` of the label.
    return str(handle._impl.uuid)
