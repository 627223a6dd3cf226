"""The ellipsoid that a fine mesh is, if it is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.box import equivalent_box

FEWEST = 100
"""Corners below which a mesh is a polyhedron and not meant to be round."""

OFF = 1e-3
"""How far corners may lie off the ellipsoid, as a part of its radii."""

LACKING = 0.05
"""Part of the ellipsoid's volume that flat faces may cut off."""


@dataclass(frozen=True, kw_only=True)
class Ellipsoid:
    """An ellipsoid in a link's frame."""

    radii: Array
    """Along its own axes, m, shape (3,)."""
    centre: Array
    """m, shape (3,)."""
    axes: Array
    """Its own axes as columns, in the link's frame, shape (3, 3); a rotation."""


def as_ellipsoid(mesh: Mesh) -> Ellipsoid | None:
    """Return the ellipsoid, of the mesh's volume, that a solid is; None if it is none."""
    if len(mesh.vertices) < FEWEST:
        return None
    # Second moments are V a^2 / 12 of a box and V a^2 / 5 of an ellipsoid: their ratios agree.
    box = equivalent_box(mesh)
    radii = box.sides * (3.0 / (4.0 * np.pi)) ** (1.0 / 3.0)
    away = np.linalg.norm((mesh.vertices - box.centre) @ box.axes / radii, axis=1)
    if np.ptp(away) > OFF or abs(away.mean() ** -3 - 1.0) > LACKING:
        return None
    return Ellipsoid(radii=radii, centre=box.centre, axes=box.axes)
