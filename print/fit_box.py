"""How a part holds a box, such as cells or a board: a tray, open to the side that costs least."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.fitting import Fitting
from morph.print.mesh import Mesh
from morph.print.printer import Profile
from morph.print.solid import frame, grown, hull, placed

WALL_MM = 1.8
"""Wall and floor of a tray."""

RIM_MM = 8.0
"""How far a tray's wall reaches up along what it holds."""


def tray(room: Mesh, body: Any, profile: Profile) -> Fitting:
    """Return the tray of a box.

    Args:
        room: The box; of other shapes, their convex hull counts.
        body: What else the part is made of, as a solid.
        profile: How much play there is.
    """
    pose = _frame(room)
    back = np.asarray(np.linalg.inv(pose), dtype=np.float64)
    solid = placed(room.manifold, back)
    inner, outer = grown(solid, profile.clearance_mm), grown(solid, profile.clearance_mm + WALL_MM)
    low, high = np.array(solid.bounding_box()).reshape(2, 3)
    there = placed(body, back)
    ways = []
    for axis in range(3):
        for way in (1.0, -1.0):
            away = np.zeros(3)
            away[axis] = way * (high - low)[axis] * 1.05
            swept = hull([inner, inner.translate(list(away))])
            ways.append((float((swept ^ there).volume()), axis, way, swept))
    # Wide and low trays hold best: equal ways out are ranked by how deep the tray would be.
    least = min(cost for cost, *_ in ways) + 1.0
    good = [each for each in ways if each[0] <= least * 1.05]
    _, axis, way, swept = min(good, key=lambda each: ((high - low)[each[1]], each[0]))
    normal = np.zeros(3)
    normal[axis] = -way
    # The plane is RIM_MM above the floor of the box.
    floor = -way * (low[axis] if way > 0 else high[axis])
    wall = outer.trim_by_plane(list(normal), float(floor - RIM_MM))
    return Fitting(
        name="the tray of a box",
        added=(placed(wall, pose),),
        removed=(placed(swept, pose),),
    )


def _frame(room: Mesh) -> Array:
    """Return a frame along the sides of a box, so that a turned box gets a turned tray."""
    a, b, c = room.corners.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    z = normals[int(np.argmax(np.round(areas, 6)))]
    z = z / np.linalg.norm(z)
    beside = areas * (np.abs(normals @ z) < 1e-3 * np.maximum(areas, 1e-12))
    if beside.max() <= 0.0:
        return frame(room.bounds.mean(axis=0), z)
    x = normals[int(np.argmax(np.round(beside, 6)))]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = room.bounds.mean(axis=0)
    return pose
