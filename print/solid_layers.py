"""Where a layer is filled solid, because a top or a bottom is near."""

from __future__ import annotations

from collections.abc import Sequence

from morph.print.printer import Profile
from morph.print.sections import Section, all_of, grown, inset, shared

BARE_MM = 0.045
"""What sticks out less than twice this beyond the next layer is no surface: a tenth of a line."""
MARGIN_MM = 3.0
"""Solid surfaces reach this far under and over what covers them, to be held there."""
NARROW_MM = 0.2
"""Solid rims of slopes that are narrower than twice this are left out; fitted to PrusaSlicer."""


def shells(cuts: Sequence[Section], inner: Sequence[Section], profile: Profile) -> list[Section]:
    """Return where each layer is filled solid.

    As PrusaSlicer does it: what the next layer leaves bare is a surface, which is widened
    where it is filled, and repeated in the layers beneath a top and above a bottom. On steep
    slopes, where the surfaces are hidden in the walls, what is inside the walls here but not
    in the layers near by is solid too.

    Source: PrusaSlicer 2.5, `PrintObject::process_external_surfaces`,
    `discover_horizontal_shells` and `discover_vertical_shells`, as far as they matter here.

    Args:
        cuts: The section of each layer, the lowest first.
        inner: What of each is inside its walls.
        profile: How many solid layers there are on top and at the bottom.
    """
    top, bottom = profile.solid_layers
    count = len(cuts)
    tops = [_surface(cuts, inner, layer, layer + 1) for layer in range(count)] if top else []
    bottoms = [_surface(cuts, inner, layer, layer - 1) for layer in range(count)] if bottom else []
    results = []
    for layer in range(count):
        near = tops[layer : layer + top] + bottoms[max(0, layer - bottom + 1) : layer + 1]
        around = inner[max(0, layer - max(bottom - 1, 0)) : layer + max(top, 1)]
        rim = inner[layer] - shared(around)
        if not rim.is_empty():
            near.append(grown(inset(rim, NARROW_MM), NARROW_MM + BARE_MM))
        results.append(all_of(near) ^ inner[layer])
    return results


def _surface(cuts: Sequence[Section], inner: Sequence[Section], layer: int, other: int) -> Section:
    """Return what a layer shows of itself where the other one, next to it, is not."""
    if not 0 <= other < len(cuts):
        return inner[layer]
    bare = cuts[layer] - cuts[other]
    if bare.is_empty():
        return bare
    bare = grown(inset(bare, BARE_MM), BARE_MM)
    filled = bare ^ inner[layer]
    return bare if filled.is_empty() else bare + grown(filled, MARGIN_MM)
