"""A tracked body's orientation as a quaternion, and its velocities in the canonical frames."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array

CANONICAL = {"linear_velocity": "world", "angular_velocity": "body"}
"""The frame that each velocity of a tracked body is kept in."""


def quaternion(values: Array, form: str) -> Array:
    """Return orientations as quaternions w, x, y, z, shape (samples, 4).

    Source: Diebel 2006, Representing Attitude, eq. 290, for roll, pitch and yaw:
    the body turns by roll about the world's x, then pitch about its y, then yaw
    about its z.

    Args:
        values: In the order of `form`, shape (samples, 3) or (samples, 4).
        form: `euler-xyz`, `quaternion-wxyz` or `quaternion-xyzw`.
    """
    if form == "quaternion-wxyz":
        return values
    if form == "quaternion-xyzw":
        return values[:, [3, 0, 1, 2]]
    (cx, cy, cz), (sx, sy, sz) = np.cos(values.T / 2.0), np.sin(values.T / 2.0)
    return np.stack(
        [
            cx * cy * cz + sx * sy * sz,
            sx * cy * cz - cx * sy * sz,
            cx * sy * cz + sx * cy * sz,
            cx * cy * sz - sx * sy * cz,
        ],
        axis=1,
    )


def turn(vector: Array, orientation: Array, *, into: str) -> Array:
    """Return vectors in the world's frame or the body's, shape (samples, 3).

    Args:
        vector: In the other of the two frames, shape (samples, 3).
        orientation: The body's unit quaternions w, x, y, z, shape (samples, 4).
        into: `world` or `body`.
    """
    sign = 1.0 if into == "world" else -1.0
    w, axis = orientation[:, :1], sign * orientation[:, 1:]
    # v + 2 w (u x v) + 2 u x (u x v) turns v by the quaternion (w, u).
    once = 2.0 * np.cross(axis, vector)
    return np.asarray(vector + w * once + np.cross(axis, once))
