"""Every view by its name, and those that suit what was given."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.errors import ViewError

VIEWS = ("compare", "design", "align", "mismatch", "print")
"""Every view by name, in the order of the tabs; each is a module here, loaded when it is needed:
they bring much along, and a page of two bodies needs little of it."""


def makers(
    given: ViewRequest, first: str | None = None
) -> tuple[tuple[Callable[[], View], ...], int]:
    """Return what makes the views that suit what was given, and which of them to begin with.

    Args:
        given: What is to be shown; what cannot be used of it is told now, before it is served.
        first: Name of the view to begin with; by default the most particular one.

    Raises:
        MorphError: Something given cannot be used.
        ViewError: Nothing was given that could be shown, or not what `first` needs.
    """
    # From the most particular to the most general: the first is what one most likely came for.
    needs = {
        "align": given.transfer is not None,
        **({"print": True} if given.package is not None else {}),
        "mismatch": bool(given.robots) and (given.diagnosis is not None or bool(given.recordings)),
        "compare": bool(given.robots),
        "design": bool(given.robots),
        **({"print": bool(given.robots)} if given.package is None else {}),
    }
    results = {name: _maker(name, given) for name, met in needs.items() if met}
    if not results:
        raise ViewError(
            "there is nothing to show",
            where="morph view",
            fix="name a robot, or a folder by --transfer or --package",
        )
    if first is not None and first not in results:
        raise ViewError(
            f"there is no view {first!r} of what was given; there are {', '.join(results)}",
            where="--first",
            fix="align needs --transfer, mismatch --recording or --diagnosis, the others a robot",
        )
    begin = next(iter(results)) if first is None else first
    tabs = [name for name in VIEWS if name in results]
    return tuple(results[name] for name in tabs), tabs.index(begin)


def _maker(name: str, given: ViewRequest) -> Callable[[], View]:
    made: Callable[[], View] = import_module(f"{__package__}.{name}").maker(given)
    return made
