"""Whether a part fits the printer's bed, turned as it may."""

from __future__ import annotations

import numpy as np

from print.bed import about_up, hull, room
from print.check.subject import Subject
from print.directions import resting, spread, turned_down
from print.part import Check


def bed_fit(subject: Subject) -> Check:
    """Return whether the part fits in some orientation; if not, it is to be cut, not refused."""
    size = " x ".join(f"{side:.0f}" for side in subject.mesh.extent)
    allowed = room(subject.profile)
    bed = " x ".join(f"{side:.0f}" for side in allowed)
    name = subject.profile.printer.title
    points = hull(subject.mesh)
    value, limit = float(np.sort(subject.mesh.extent)[-1]), float(allowed.max())
    span = float(np.linalg.norm(np.ptp(points, axis=0)))
    if span <= allowed.min() or _fits(subject, points):
        what = f"{size} mm fits {bed} mm on the {name}"
        return subject.says("bed fit", "passed", what, value=value, limit=limit)
    what = f"{size} mm does not fit {bed} mm on the {name}, however it lies"
    fix = "it is cut into pieces with pins; a larger printer would print it whole"
    return subject.says("bed fit", "noted", what, fix, value=value, limit=limit)


def _fits(subject: Subject, points: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> bool:
    downward = np.concatenate([-np.eye(3), resting(subject.mesh), spread()])
    return any(
        about_up(points @ turned_down(down).T, subject.profile) is not None for down in downward
    )
