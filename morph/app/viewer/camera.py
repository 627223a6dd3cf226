"""From where somebody looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A place to look from, and what is looked at."""

    position: Point
    """Where the camera is, m."""
    look_at: Point
    """What it looks at, m."""

    def turn(self, camera: Any) -> None:
        """Turn a camera of viser's there."""
        camera.position, camera.look_at = self.position, self.look_at


def camera_of(camera: Any) -> Camera | None:
    """Return from where a client looks; None while its page has not said so."""
    try:
        at, towards = (tuple(map(float, point)) for point in (camera.position, camera.look_at))
    except AssertionError:
        # viser asserts that a page has told it.
        return None
    return Camera(position=(at[0], at[1], at[2]), look_at=(towards[0], towards[1], towards[2]))
