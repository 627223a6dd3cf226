"""Which links are one rigid body, and how their frames lie to each other."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.fabrication.drawing import Drawing


def roots(robot: Robot) -> dict[str, str]:
    """Return for each link the first one of those that it is rigidly fixed to."""
    moved = {joint.link for joint in robot.joints}
    known = {link.name for link in robot.links}
    results: dict[str, str] = {}
    for link in robot.links:
        fixed = link.name not in moved and link.parent in known
        results[link.name] = results.get(link.parent, link.parent) if fixed else link.name
    return results


def between(drawing: Drawing, link: str, other: str) -> Array:
    """Return the transform from one link's frame to another's, mm, with all joints at zero."""
    pose: Array = np.linalg.inv(drawing.world(other)) @ drawing.world(link)
    return pose
