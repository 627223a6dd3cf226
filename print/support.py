"""How much support a part needs, from its sections alone."""

from __future__ import annotations

import numpy as np

from print.printer import Profile
from print.sections import Section
from print.settings import SUPPORT_SPACING_MM

GAP_MM = 0.2
"""Distance that support keeps from the sides of the part."""
SMALL_MM = 0.5
"""Overhangs narrower than twice this hold by themselves."""


def support_mm3(cuts: list[Section], profile: Profile) -> float:
    """Return the volume of plastic that holds up what overhangs.

    From the top down: what a layer has beyond the layer below, by more than the allowed lean,
    is held up down to the bed or to the part itself.

    Args:
        cuts: The part's section at each layer, the lowest first.
        profile: The lean allowed, and the lines.
    """
    import manifold3d

    reach = profile.layer_mm * np.tan(np.radians(profile.overhang_deg))
    fill = profile.line_mm / SUPPORT_SPACING_MM
    column = manifold3d.CrossSection()
    area = 0.0
    for layer in range(len(cuts) - 1, 0, -1):
        below = cuts[layer - 1]
        beyond = cuts[layer] - below.offset(reach, manifold3d.JoinType.Round)
        if not beyond.is_empty():
            beyond = beyond.offset(-SMALL_MM / 2.0).offset(SMALL_MM / 2.0)
            column = column + beyond
        if not column.is_empty():
            column = column - below.offset(GAP_MM, manifold3d.JoinType.Miter)
            area += column.area()
    return float(area * profile.layer_mm * fill)
