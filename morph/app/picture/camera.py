"""Where the camera stands: so that it follows the robot and has all of it in the picture."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array

STILL = 2.2
"""The camera stands still if all of a motion takes no more room than this many robots."""

SMOOTHED = 0.35
"""Seconds over which the camera's own movement is smoothed."""

ASPECT = 16.0 / 9.0
"""Width of a picture by its height."""

AZIMUTH, ELEVATION = 118.0, -14.0
"""Where the camera looks, degrees: from the robot's front right, a little from above."""

MARGIN = 1.15
"""Room around the robot."""


@dataclass(frozen=True, kw_only=True)
class Framing:
    """What the camera looks at, and from how far."""

    lookat: Array
    """The middle of each picture, m, shape (pictures, 3)."""
    distance: float
    """From the camera to there, m."""
    radius: float
    """Of what must be in the picture, m."""
    lowest: float
    """The lowest point that the robot reaches, m."""


def framing(model: Any, positions: Array, rate: float) -> Framing:
    """Return where the camera looks in every picture of a motion.

    Args:
        model: The `mujoco.MjModel` that is drawn.
        positions: Its `qpos` in each picture, shape (pictures, nq).
        rate: Pictures a second.
    """
    low, high = _boxes(model, positions)
    middle = 0.5 * (low + high)
    robot = 0.5 * float(np.linalg.norm(high - low, axis=1).max())
    whole_low, whole_high = low.min(axis=0), high.max(axis=0)
    whole = 0.5 * float(np.linalg.norm(whole_high - whole_low))
    if whole <= STILL * robot:
        lookat, radius = np.tile(0.5 * (whole_low + whole_high), (len(positions), 1)), whole
    else:
        lookat = _smoothed(middle, SMOOTHED * rate)
        radius = robot + float(np.linalg.norm(middle - lookat, axis=1).max())
    radius = max(radius, 1e-3)
    tangent = float(np.tan(0.5 * np.deg2rad(float(model.vis.global_.fovy))))
    return Framing(
        lookat=lookat,
        distance=max(MARGIN * _distance(low - lookat, high - lookat, tangent), radius),
        radius=radius,
        lowest=float(whole_low[2]),
    )


def _distance(low: Array, high: Array, tangent: float) -> float:
    """Return from how far all corners of boxes around the middle are in the picture, m.

    A corner p, to the right by p.r, up by p.u and behind by p.f, is in the picture from a
    distance d when |p.r| <= aspect tangent (d + p.f) and |p.u| <= tangent (d + p.f).

    Args:
        low: The boxes' lower corners, from the middle of the picture, m, shape (pictures, 3).
        high: Their upper corners.
        tangent: Of half the angle of view, from the middle to the picture's upper edge.
    """
    azimuth, elevation = np.deg2rad(AZIMUTH), np.deg2rad(ELEVATION)
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    forward = np.cos(elevation) * level + np.array([0.0, 0.0, np.sin(elevation)])
    right = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
    up = np.cross(right, forward)
    choice = np.array(list(product((0.0, 1.0), repeat=3)))
    corners = low[:, None] + choice * (high - low)[:, None]
    aside = np.abs(corners @ right) / (ASPECT * tangent)
    above = np.abs(corners @ up) / tangent
    return float((np.maximum(aside, above) - corners @ forward).max())


def _boxes(model: Any, positions: Array) -> tuple[Array, Array]:
    """Return the corners of the robot's upright box in every picture, (pictures, 3) each."""
    endless = (mujoco.mjtGeom.mjGEOM_PLANE.value, mujoco.mjtGeom.mjGEOM_HFIELD.value)
    seen = [
        geom
        for geom in range(model.ngeom)
        if model.geom_type[geom] not in endless and model.geom_group[geom] < 3
    ]
    data = mujoco.MjData(model)
    low, high = np.empty((len(positions), 3)), np.empty((len(positions), 3))
    for at, position in enumerate(positions):
        data.qpos[:] = position
        mujoco.mj_kinematics(model, data)
        if seen:
            turn = data.geom_xmat[seen].reshape(-1, 3, 3)
            centre = data.geom_xpos[seen] + (turn @ model.geom_aabb[seen, :3, None])[..., 0]
            half = (np.abs(turn) @ model.geom_aabb[seen, 3:, None])[..., 0]
        else:
            centre, half = data.xpos, np.full_like(data.xpos, 0.05)
        low[at], high[at] = (centre - half).min(axis=0), (centre + half).max(axis=0)
    return low, high


def _smoothed(path: Array, width: float) -> Array:
    """Return a path without its quick movements, same shape: a Gaussian of a width in rows."""
    reach = int(3.0 * width) + 1
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(width, 1e-9)) ** 2)
    # Mirrored about its ends, the path goes on as fast as it went.
    first, last = path[:1], path[-1:]
    before = 2.0 * first - np.take(path, np.arange(reach, 0, -1), axis=0, mode="clip")
    after = 2.0 * last - np.take(path, len(path) - 2 - np.arange(reach), axis=0, mode="clip")
    long = np.concatenate([before, path, after])
    columns = [np.convolve(column, weight / weight.sum(), mode="valid") for column in long.T]
    return np.stack(columns, axis=1)
