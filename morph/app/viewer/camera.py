"""Camera of a page: position and target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array

Point = tuple[float, float, float]

UP = np.array([0.0, 0.0, 1.0])
"""Unit vector upwards: z in every world."""


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Position and target of a camera."""

    position: Point
    """Position of the camera, m."""
    look_at: Point
    """Point that it looks at, m."""

    def turn(self, camera: Any) -> None:
        """Set a camera of viser to this position and target."""
        turn(camera, np.array(self.position), np.array(self.look_at))


def turn(camera: Any, position: Array, look_at: Array) -> None:
    """Set the position and the target of a viser camera.

    viser translates the target with the position, and sends no target that equals its record of
    the page's camera. A late message of the page may restore that record after the position is
    set: an unchanged target would then not be sent, and the page keep the translated one. So the
    target is set twice, first displaced by a thousandth of its distance: at least one is sent.

    Args:
        camera: `viser.CameraHandle` of a client.
        position: New position, m, shape (3,).
        look_at: New target, m, shape (3,).
    """
    camera.position = position
    camera.look_at = look_at + 1e-3 * float(np.linalg.norm(look_at - position)) * UP
    camera.look_at = look_at


def camera_of(camera: Any) -> Camera | None:
    """Return the camera of a client; None before its page has sent it.

    Args:
        camera: `viser.CameraHandle` of the client.
    """
    try:
        at, target = (tuple(map(float, point)) for point in (camera.position, camera.look_at))
    except AssertionError:
        # viser raises it before the page's first message of its camera.
        return None
    return Camera(position=(at[0], at[1], at[2]), look_at=(target[0], target[1], target[2]))
