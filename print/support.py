"""How much support a part needs, from its sections alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.print.printer import Profile
from morph.print.sections import Section, all_of, grown
from morph.print.settings import SUPPORT_SPACING_MM

GAP_MM = 0.225
"""Distance that support keeps from the sides of the part: half a line."""
CLOSED_MM = 2.0
"""Gaps in support that are narrower than twice this are filled."""
DENSE_LAYERS = 2
"""Layers under what is held up in which lines lie close."""
DENSE_SPACING_MM = 0.2
"""Gaps between those lines."""
WIDER_MM = 1.5
"""Support is so much wider than what it holds."""
OUTLINE_MM = 0.5
"""The lines of support turn along its outline, as if it were so much wider."""
REST_MM = 0.3
"""A bridge rests on what is so near to it."""
RESTS, WIDE_RESTS, WIDE_MM = 0.55, 0.4, 3.0
"""An overhang of which this part of the outline rests on the layer below is a bridge; less is
enough of one that is wide, because what is narrow is the rim of a slope and rests by nature."""


def support_mm3(cuts: Sequence[Section], profile: Profile) -> float:
    """Return the volume of plastic that holds up what overhangs.

    From the top down: what a layer has beyond the layer below, by more than the allowed lean,
    and is no bridge, is held up down to the bed or to the part itself. It is a rough figure,
    mostly within a factor of 1.6 of PrusaSlicer's, to which its constants were fitted.

    Args:
        cuts: The part's section at each layer, the lowest first.
        profile: The lean allowed, and the lines.
    """
    line = profile.line_mm - profile.layer_mm * (1.0 - np.pi / 4.0)
    dense = line / (line + DENSE_SPACING_MM)
    loose = line / (line + SUPPORT_SPACING_MM)
    column = all_of([])
    sums = 0.0
    for layer in range(len(cuts) - 1, 0, -1):
        below = cuts[layer - 1]
        held = overhang(cuts[layer], below, profile)
        if not held.is_empty():
            column = column + closed(grown(held, WIDER_MM) - grown(below, GAP_MM))
            sums += held.area() * DENSE_LAYERS * (dense - loose)
        if not column.is_empty():
            column = (column - grown(below, GAP_MM)).simplify(0.1)
            sums += grown(column, OUTLINE_MM).area() * loose
    return float(sums * profile.layer_mm)


def overhang(cut: Section, below: Section, profile: Profile) -> Section:
    """Return what of a layer needs support, given the layer below it."""
    # Upright to level: at 90 degrees nothing leans too far, and the tangent has no end.
    lean = min(profile.overhang_deg, 89.0)
    reach = profile.layer_mm * np.tan(np.radians(lean))
    beyond = cut - grown(below, reach)
    if beyond.is_empty():
        return beyond
    # The slicer holds up all of what hangs over, not only what hangs over too far.
    beyond = (grown(beyond, reach) ^ cut) - below
    return all_of([each for each in beyond.decompose() if not _bridges(each, below)])


def closed(section: Section) -> Section:
    """Return a section without narrow gaps."""
    return grown(grown(section, CLOSED_MM), -CLOSED_MM)


def _bridges(beyond: Section, below: Section) -> bool:
    """Return whether most of an overhang's outline rests on the layer below."""
    around = grown(beyond, REST_MM) - beyond
    wide = not grown(beyond, -WIDE_MM / 2.0).is_empty()
    enough = WIDE_RESTS if wide else RESTS
    return bool((around ^ below).area() > enough * around.area())
