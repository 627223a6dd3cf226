"""The G-code of whole plates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from threading import Event

from morph.print.bed_pose import mesh_of
from morph.print.job import Job, Plate
from morph.print.mesh import Mesh
from morph.print.prepare import at_once
from morph.print.slicer import Code, Slicer


def codes(
    job: Job,
    slicer: Slicer,
    *,
    tell: Callable[[str], None] = lambda _: None,
    timeout_s: float = 300.0,
) -> dict[str, Code]:
    """Return the G-code of every plate by its name, each with what the slicer warned of.

    Args:
        job: The job; its parts lie on their plates as it says.
        slicer: The slicer.
        tell: Is told what is being done now.
        timeout_s: Seconds that the slicer may take for each part on a plate.

    Raises:
        SlicerError: The slicer is missing, hangs, dies, or writes what cannot be used.
    """
    meshes = {part.name: mesh_of(part) for part in (*job.parts, *job.gauges) if part.mesh}

    mine = replace(slicer, stop=Event())

    def ask(plate: Plate) -> Code:
        tell(f"slicing {plate.name}")
        limit = timeout_s * max(1, len(plate.laid))
        return mine.code(_lying(plate, meshes), job.profile, timeout_s=limit)

    return at_once({plate.name: partial(ask, plate) for plate in job.plates}, mine)


def _lying(plate: Plate, meshes: dict[str, Mesh]) -> dict[str, Mesh]:
    return {
        f"{laid.part}-{laid.copy + 1}": meshes[laid.part].moved(laid.pose) for laid in plate.laid
    }
