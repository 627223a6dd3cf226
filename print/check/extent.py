"""Whether a part's size is one that a part can have: millimetres are nowhere written in a mesh."""

from __future__ import annotations

import numpy as np

from morph.print.check.subject import Subject
from morph.print.part import Check

LEAST_MM, MOST_MM = 1.0, 2000.0
"""The largest side of a part lies between these; a part in metres is a thousand times too small."""
SMALL_MM = 3.0
"""A part whose largest side is shorter is printed, and easily lost."""


def extent(subject: Subject) -> Check:
    """Return whether the largest side is at least 1 mm and at most 2 m."""
    mesh = subject.part.mesh
    if mesh is None or not len(mesh.faces) or not len(mesh.vertices):
        return subject.says("extent", "refused", "there is no mesh, or it is empty", EXPORT)
    if not np.isfinite(mesh.vertices).all():
        bad = int((~np.isfinite(mesh.vertices)).any(axis=1).sum())
        what = f"{bad} of {len(mesh.vertices)} corners are not at finite numbers"
        return subject.says("extent", "refused", what, EXPORT)
    largest = float(mesh.extent.max())
    size = " x ".join(f"{side:.4g}" for side in mesh.extent)
    if largest < LEAST_MM:
        what = f"it is {size} mm large, and the largest side is at least {LEAST_MM:g} mm"
        fix = "give it in millimetres; it looks like metres, so scale it by 1000"
        return subject.says("extent", "refused", what, fix, value=largest, limit=LEAST_MM)
    if largest > MOST_MM:
        what = f"it is {size} mm large, and the largest side is at most {MOST_MM:g} mm"
        fix = "give it in millimetres; it looks like micrometres or a scale applied twice"
        return subject.says("extent", "refused", what, fix, value=largest, limit=MOST_MM)
    if largest < SMALL_MM:
        what = f"it is {size} mm large: easily lost on the plate"
        fix = "see that it was meant in millimetres"
        return subject.says("extent", "noted", what, fix, value=largest, limit=SMALL_MM)
    return subject.says("extent", "passed", f"{size} mm", value=largest, limit=MOST_MM)


EXPORT = "export the part again"
"""What puts right a mesh that holds nothing."""
