"""Where a camera stands so that it sees all there is, from as near as can be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array

FIELD = math.radians(40.0)
"""Angle that a camera sees from bottom to top."""

ASPECT = 1.2
"""Width of a picture by its height, where a browser has not told it."""

FILLED = 0.86
"""Part of the picture's width and height that is filled; names and knobs need the rest."""


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A camera's place."""

    position: Array
    """Where it is, m, shape (3,)."""
    target: Array
    """What it looks at, and turns about, m, shape (3,)."""

    @property
    def distance(self) -> float:
        """How far it is from what it looks at, m."""
        return float(np.linalg.norm(self.position - self.target))


def framed(points: Array, towards: Array, aspect: float = ASPECT) -> Frame:
    """Return the nearest place from which all points are in the picture.

    A point that is `x` to the right of the camera and `z` before it is in the picture if
    `|x| <= z t`, where `t` is the tangent of half the field. With the direction given, these
    are two bounds on the camera's place for either axis, and the nearest place that all leave
    is known in closed form.

    Args:
        points: What must be seen, m, shape (points, 3).
        towards: Unit vector from there to the camera, not upright, shape (3,).
        aspect: Width of the picture by its height.
    """
    forward = -towards
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    tangent = FILLED * math.tan(0.5 * FIELD)
    depth = points @ forward
    least, most, nearest = [], [], []
    for axis, slope in ((right, tangent * aspect), (up, tangent)):
        across = points @ axis
        least.append(float((across - slope * depth).max()))
        most.append(float((across + slope * depth).min()))
        nearest.append((most[-1] - least[-1]) / (2.0 * slope))
    # Never inside of what it looks at, should that be thin and seen from its end.
    clear = 1e-3 * (float(np.ptp(points, axis=0).max()) or 1.0)
    along = min(*nearest, float(depth.min()) - clear)
    place = 0.5 * (least[0] + most[0]) * right + 0.5 * (least[1] + most[1]) * up
    middle = 0.5 * float(depth.min() + depth.max())
    return Frame(position=place + along * forward, target=place + middle * forward)
