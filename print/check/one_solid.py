"""Whether a part is one solid: what is apart on the plate is apart in the hand."""

from __future__ import annotations

from morph.print.check.subject import Subject
from morph.print.mesh import Mesh
from morph.print.part import Check

NAMED = 5
"""How many pieces are told with their size."""


def one_solid(subject: Subject) -> Check:
    """Return whether the part is in one piece.

    Crumbs, smaller on each side than the thinnest wall, are noted: no slicer lays them down.
    """
    solids = [piece for piece in subject.pieces if piece.volume > 0]
    voids = len(subject.pieces) - len(solids)
    thinnest = subject.profile.thinnest_mm
    large = [solid for solid in solids if solid.extent.max() >= thinnest]
    if len(large) > 1:
        what = f"{len(large)} solids in one mesh, where 1 is allowed: {_sizes(large)}"
        fix = "give each solid as a part of its own, or join them where they are to touch"
        return subject.says("one solid", "refused", what, fix, value=len(large), limit=1)
    if len(solids) > len(large):
        crumbs = len(solids) - len(large)
        what = f"{crumbs} crumb{'s' if crumbs > 1 else ''} beside the part, no slicer prints: "
        what += _sizes([solid for solid in solids if solid.extent.max() < thinnest])
        return subject.says(
            "one solid", "noted", what, "remove them from the mesh", value=len(large), limit=1
        )
    if voids:
        what = f"one solid with {voids} closed void{'s' if voids > 1 else ''} inside"
        fix = "see that nothing was to be put in, and that no support has to come out"
        return subject.says("one solid", "noted", what, fix, value=1, limit=1)
    return subject.says("one solid", "passed", "one solid", value=1, limit=1)


def _sizes(solids: list[Mesh]) -> str:
    given = [" x ".join(f"{side:.3g}" for side in solid.extent) for solid in solids[:NAMED]]
    more = len(solids) - len(given)
    return ", ".join(given) + " mm" + (f" and {more} more" if more else "")
