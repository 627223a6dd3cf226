"""Whether a part fits the printer's bed, lying on some face of its hull."""

from __future__ import annotations

import numpy as np

from morph.print.bed import hull, room
from morph.print.check.subject import Subject
from morph.print.orient import fits
from morph.print.part import Check


def bed_fit(subject: Subject) -> Check:
    """Return whether the part fits on some face of its hull; if not, it is cut, not refused."""
    size = " x ".join(f"{side:.0f}" for side in subject.mesh.extent)
    allowed = room(subject.profile)
    bed = " x ".join(f"{side:.0f}" for side in allowed)
    name = subject.profile.printer.title
    points = hull(subject.mesh)
    value, limit = float(np.sort(subject.mesh.extent)[-1]), float(allowed.max())
    span = float(np.linalg.norm(np.ptp(points, axis=0)))
    if span <= allowed.min() or fits(subject.mesh, subject.profile):
        what = f"{size} mm fits {bed} mm on the {name}"
        return subject.says("bed fit", "passed", what, value=value, limit=limit)
    what = f"{size} mm does not fit {bed} mm on the {name}, however it lies"
    fix = "it is cut into pieces with pins; a larger printer would print it whole"
    return subject.says("bed fit", "noted", what, fix, value=value, limit=limit)
