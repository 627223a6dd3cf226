"""Making one solid of the pieces of a part: crumbs are dropped, the others joined by struts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scipy.spatial import KDTree

from morph.print.errors import SolidError
from morph.print.solid import NOTHING, pieces, union
from morph.print.strut import points, strut

CRUMB = 0.02
"""Part of the whole volume below which a piece that carries nothing is dropped."""

SLIVER_MM = 0.005
"""Triangles narrower than this are removed."""

CRUMB_MM3 = 1000.0
"""And its greatest volume."""


def connected(
    solid: Any, forbidden: Any, carriers: Sequence[Any], *, where: str
) -> tuple[Any, tuple[str, ...]]:
    """Return a part in one piece, and what was done to make it one.

    Args:
        solid: The part, cut; it may be in pieces.
        forbidden: Where nothing may be.
        carriers: Plastic that carries something: a piece with some of it is no crumb.
        where: The part's name.

    Raises:
        SolidError: Nothing is left, or two pieces cannot be joined.
    """
    whole = pieces(solid)
    if not whole:
        raise SolidError(
            "nothing is left of it: what it holds and what others sweep takes all",
            where=where,
            fix="draw more of it, or move what it holds",
        )
    total = sum(piece.volume() for piece in whole)
    kept = [p for p in whole if not _crumb(p, total, carriers)] or whole[:1]
    notes = []
    if len(kept) < len(whole):
        lost = total - sum(piece.volume() for piece in kept)
        notes.append(f"{len(whole) - len(kept)} crumbs of {lost:.0f} mm3 in all are left out")
    # Faces that all but coincide leave slivers that no printer lays down.
    loose = [_loose(piece, total, carriers) for piece in kept]
    one, left = _joined(kept, loose, forbidden, where)
    if len(kept) - len(left) > 1:
        notes.append(f"{len(kept) - len(left)} separate pieces are joined by struts")
    notes += [f"{_said(piece)} is left out: nothing can join it" for piece in left]
    return pieces(one.simplify(SLIVER_MM))[0], tuple(notes)


def _crumb(piece: Any, total: float, carriers: Sequence[Any]) -> bool:
    return piece.volume() <= min(CRUMB * total, CRUMB_MM3) and _idle(piece, carriers)


def _loose(piece: Any, total: float, carriers: Sequence[Any]) -> bool:
    """Return whether a part may do without a piece: a small one that carries nothing."""
    return bool(piece.volume() <= CRUMB * total) and _idle(piece, carriers)


def _idle(piece: Any, carriers: Sequence[Any]) -> bool:
    # A boss may be small, but it is no crumb; a sliver of one is.
    return all((piece ^ each).volume() < 0.3 * each.volume() for each in carriers)


def _joined(
    kept: list[Any], loose: list[bool], forbidden: Any, where: str
) -> tuple[Any, list[Any]]:
    """Return pieces as one, the nearest joined first, and those that the part does without."""
    one = kept[0]
    rest = [(piece, points(piece), free) for piece, free in zip(kept, loose, strict=True)][1:]
    while rest:
        tree = KDTree(points(one))
        rest.sort(key=lambda other: float(tree.query(other[1])[0].min()))
        for k, (piece, *_) in enumerate(rest):
            between = strut(one, piece, forbidden)
            if between is not None:
                one = pieces(union([one, piece, between]))[0]
                del rest[k]
                break
        else:
            break
    stuck = [piece for piece, _, free in rest if not free]
    if stuck:
        raise SolidError(
            f"{_said(stuck[0])} cannot be joined to the rest: what the part holds and what "
            "others sweep lies between",
            where=where,
            fix="move what is in the way, or draw a piece that leads around it",
        )
    return one, [piece for piece, *_ in rest]


def _said(piece: Any) -> str:
    low, high = piece.bounding_box()[:3], piece.bounding_box()[3:]
    if piece.volume() < NOTHING:
        return "a piece"
    middle = ", ".join(f"{(a + b) / 2:.0f}" for a, b in zip(low, high, strict=True))
    return f"a piece of {piece.volume() / 1e3:.1f} cm3 about ({middle}) mm"
