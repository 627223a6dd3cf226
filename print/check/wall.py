"""Whether walls are thick enough to be laid down."""

from __future__ import annotations

import math

import numpy as np

from morph.print.check.subject import Subject
from morph.print.part import Check

NARROWEST = 0.85
"""How narrow a line can be laid, by the nozzle's bore: the default of PrusaSlicer's
`--min-bead-width`, as `prusa-slicer --help-fff` states it."""
SHARE, TOLD = 0.25, 0.01
"""Of the surface: more than `SHARE` on walls that cannot be printed refuses a part; more than
`TOLD` on walls that print thinner than two full lines is told."""
OPPOSED = math.cos(math.radians(30.0))
"""A wall has two sides that face away from each other to 30 degrees; a sharp edge has not."""


def wall(subject: Subject) -> Check:
    """Return whether walls hold two lines.

    Two lines at their narrowest are a wall's least; between that and two full lines a wall is
    printed with the slicer's compromises, and told. Single thin spots, such as engraved letters,
    pins and tips, do not refuse a part; a part that is made of thin walls is refused.
    """
    two = subject.profile.thinnest_mm
    least = min(2.0 * NARROWEST * subject.profile.printer.nozzle_mm, two)
    thickness = np.where(subject.walls.opposed > OPPOSED, subject.walls.thickness_mm, np.inf)
    lost, thin = (float((thickness < limit).mean()) for limit in (least, two))
    if max(lost, thin) <= TOLD:
        what = f"walls hold two lines ({two:g} mm)"
        return subject.says("wall", "passed", what, limit=two)
    result = thickness[thickness < two]
    typical, area = float(np.median(result)), subject.surface.area * len(result)
    if lost > SHARE:
        typical = float(np.median(result[result < least]))
        what = (
            f"{100 * lost:.0f} % of its surface is on walls of {typical:.2g} mm (median), and two "
            f"lines at their narrowest need {least:.2g} mm"
        )
        fix = f"make its walls {two:g} mm thick or more"
        return subject.says("wall", "refused", what, fix, value=typical, limit=least)
    what = (
        f"{area:.0f} mm2 of its surface ({100 * thin:.0f} %) is on walls thinner than two lines "
        f"({two:g} mm), {typical:.2g} mm at the median"
    )
    fix = "see in the slicer's preview what becomes of them"
    return subject.says("wall", "noted", what, fix, value=typical, limit=two)
