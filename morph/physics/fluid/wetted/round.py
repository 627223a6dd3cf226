"""The tensor of a mesh that is an ellipsoid, a cylinder or a capsule, by the short way."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor import Tensor, ellipsoid_tensor, rod_tensor
from morph.physics.fluid.wetted.box import Box, equivalent_box

OFF = 1e-3
"""How far corners may lie off the round surface, as a part of its radius."""

LACKING = 0.05
"""Part of the volume that flat faces may cut off: that of a circle as a polygon of 12."""


def round_tensor(mesh: Mesh) -> Tensor | None:
    """Return the tensor of a solid about the origin of its frame; None if it is not round.

    Of the ellipsoid, cylinder or capsule whose surface holds all corners of the mesh, in
    the size at which it has the mesh's volume.
    """
    box = equivalent_box(mesh)
    away = (mesh.vertices - box.centre) @ box.axes
    result = _ellipsoid(away, box)
    for axis in range(3):
        # Axes in turn stay a rotation, the last of them that of the rod.
        order = [(axis + 1) % 3, (axis + 2) % 3, axis]
        if result is None:
            result = _rod(away[:, order], box.axes[:, order], mesh.volume)
    return None if result is None else result.shifted(box.centre)


def _ellipsoid(away: Array, box: Box) -> Tensor | None:
    # Second moments are V a^2 / 12 of a box and V a^2 / 5 of an ellipsoid: their ratios agree.
    radii = box.sides * (3.0 / (4.0 * np.pi)) ** (1.0 / 3.0)
    length = np.linalg.norm(away / radii, axis=1)
    # Flat faces lie within the corners; the ellipsoid has the volume, and so is smaller.
    if np.ptp(length) > OFF or abs(length.mean() ** -3 - 1.0) > LACKING:
        return None
    return ellipsoid_tensor(*radii.tolist()).turned(box.axes)


def _rod(away: Array, axes: Array, volume: float) -> Tensor | None:
    """Return the tensor of a rod along the last axis about its centre, if corners lie on one."""
    height, out = np.abs(away[:, 2]), np.linalg.norm(away[:, :2], axis=1)
    half, radius = float(height.max()), float(out.max())
    flat = np.minimum(np.abs(out - radius), np.abs(height - half)).max() < OFF * radius
    side = max(half - radius, 0.0)
    apart = np.hypot(out, np.maximum(height - side, 0.0)) - radius
    rounded = not flat and bool(np.abs(apart).max() < OFF * radius)
    whole = np.pi * radius**2 * (2.0 * side + 4.0 / 3.0 * radius if rounded else 2.0 * half)
    if not (flat or rounded) or abs(volume / whole - 1.0) > LACKING:
        return None
    grown = (volume / whole) ** (1.0 / 3.0)
    try:
        length = 2.0 * grown * (side if rounded else half)
        return rod_tensor(grown * radius, length, rounded=rounded).turned(axes)
    except RobotError:
        # Thinner than its panels may be.
        return None
