"""Whether a surface passes through itself, or solids of one mesh lie in each other."""

from __future__ import annotations

import numpy as np

from morph.print.check.subject import Subject
from morph.print.part import Check

SHARE, TOLD = 0.01, 0.002
"""Of the surface, inside the part or with it on both sides: more than `SHARE` refuses a part, more
than `TOLD` is told. Below that it is a sliver where two faces meet."""


def overlap(subject: Subject) -> Check:
    """Return whether just inside the surface is in the part once, and just outside not at all."""
    wrong = (subject.depth(-1.0) != 1) | (subject.depth(1.0) != 0)
    share = float(wrong.mean())
    area = subject.surface.area * int(wrong.sum())
    if share > SHARE:
        at = np.round(subject.surface.points[wrong].mean(axis=0), 1)
        what = (
            f"its surface passes through itself: {100 * share:.1f} % of it ({area:.0f} mm2), "
            f"about ({', '.join(f'{x:g}' for x in at)}) mm, of which {100 * SHARE:g} % is allowed"
        )
        fix = "export it anew, not thinned for a simulator, with motors and plastic as parts apart"
        return subject.says("overlap", "refused", what, fix, value=share, limit=SHARE)
    if share > TOLD:
        what = f"{100 * share:.2f} % of its surface passes through itself ({area:.1f} mm2)"
        fix = "look at it in the slicer"
        return subject.says("overlap", "noted", what, fix, value=share, limit=SHARE)
    what = "its surface does not pass through itself"
    return subject.says("overlap", "passed", what, value=share, limit=SHARE)
