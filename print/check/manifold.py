"""Whether a mesh encloses a solid."""

from __future__ import annotations

from morph.print.check.subject import Subject
from morph.print.edges import trouble
from morph.print.errors import SolidError
from morph.print.part import Check


def manifold(subject: Subject) -> Check:
    """Return whether manifold3d takes the mesh, with its word for what is wrong if not."""
    try:
        volume = float(subject.mesh.manifold.volume())
    except SolidError as error:
        why = "" if subject.part.mesh is None else trouble(subject.part.mesh)
        what = error.what + (f": {why}" if why else "")
        return subject.says("manifold", "refused", what, error.fix)
    if volume <= 0:
        what = f"it encloses {volume:.4g} mm3: it is flat, inside out, or passes through itself"
        return subject.says("manifold", "refused", what, "export it as one closed solid")
    return subject.says("manifold", "passed", f"encloses {volume:.4g} mm3", value=volume)
