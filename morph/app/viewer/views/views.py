"""Every view by its name, and those that suit what was given."""

from __future__ import annotations

from collections.abc import Callable

from morph.app.viewer.given import Given
from morph.app.viewer.view import View
from morph.app.viewer.views import align, compare, design, mismatch
from morph.errors import ViewError

VIEWS = {
    view.name: view for view in (compare.Compare, design.Design, align.Align, mismatch.Mismatch)
}
"""Every view, in the order of the tabs."""


def makers(given: Given, first: str | None = None) -> tuple[tuple[Callable[[], View], ...], int]:
    """Return what makes the views that suit what was given, and which of them to begin with.

    Args:
        given: What is to be shown; what cannot be used of it is told now, before it is served.
        first: Name of the view to begin with; by default the most particular one.

    Raises:
        MorphError: Something given cannot be used.
        ViewError: Nothing was given that could be shown, or not what `first` needs.
    """
    found: dict[str, Callable[[], View]] = {}
    # From the most particular to the most general: the first is what one most likely came for.
    if given.transfer is not None:
        found["align"] = align.maker(given)
    if given.robots and (given.diagnosis is not None or given.recordings):
        found["mismatch"] = mismatch.maker(given)
    if given.robots:
        found["compare"] = compare.maker(given)
        found["design"] = design.maker(given)
    if not found:
        raise ViewError(
            "there is nothing to show",
            where="morph view",
            fix="name a robot, or a folder by --transfer",
        )
    if first is not None and first not in found:
        raise ViewError(
            f"there is no view {first!r} of what was given; there are {', '.join(found)}",
            where="--first",
            fix="align needs --transfer, mismatch --recording or --diagnosis, the others a robot",
        )
    begin = next(iter(found)) if first is None else first
    tabs = [name for name in VIEWS if name in found]
    return tuple(found[name] for name in tabs), tabs.index(begin)
