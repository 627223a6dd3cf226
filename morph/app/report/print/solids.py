"""The parts of a body as triangles that a page can turn round: together, and taken apart."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.arrays import JSON, Array
from morph.fabrication.content import Package
from morph.print.decimate import lighter
from morph.print.explode import exploded
from morph.print.mesh import Mesh
from morph.print.part import Part

FACES = 600
"""Most faces of a copy on the page: twenty parts stay under half a megabyte."""

MOST = 20_000
"""Most faces of all copies together."""


def solids(package: Package) -> list[JSON]:
    """Return each copy of each part: its corners in mm, its triangles, and where it is moved."""
    parts = [part for part in package.job.parts if part.mesh is not None]
    copies = sum(part.count for part in parts)
    most = max(24, min(FACES, MOST // max(1, copies)))
    apart = exploded(parts, package.hinges)
    drawn = []
    for part in parts:
        if part.mesh is None:
            continue
        mesh = lighter(part.mesh, most)
        for copy, placement in enumerate(part.placements):
            at = mesh.moved(placement.world)
            drawn.append(_solid(part, at, apart.offsets.get((part.name, copy), np.zeros(3))))
    return drawn


def _solid(part: Part, mesh: Mesh, moved: Array) -> dict[str, Any]:
    corners = np.round(mesh.vertices, 1)
    return {
        "name": part.name,
        "kind": part.kind,
        "x": corners[:, 0].tolist(),
        "y": corners[:, 1].tolist(),
        "z": corners[:, 2].tolist(),
        "i": mesh.faces[:, 0].tolist(),
        "j": mesh.faces[:, 1].tolist(),
        "k": mesh.faces[:, 2].tolist(),
        "moved": np.round(moved, 1).tolist(),
    }
