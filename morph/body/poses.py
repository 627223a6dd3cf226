"""Poses that a body can take, drawn anywhere in the ranges of its joints."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.body.posture import Posture

POSES = 200
"""Poses that are drawn, beside the one at rest."""

SEED = 0
"""Of that draw: the same poses for every variation, so that figures differ by the body alone."""


def drawn(posture: Posture) -> list[Array]:
    """Return the pose at rest and `POSES` others, each handle anywhere in its range.

    One that closed loops keep from its goal counts where it was stopped.
    """
    rng = np.random.default_rng(SEED)
    low = np.array([each.low if each.ranged else each.rest for each in posture.handles])
    high = np.array([each.high if each.ranged else each.rest for each in posture.handles])
    if not len(low):
        return [posture.rest]
    goals = rng.uniform(low, high, size=(POSES, len(low)))
    poses, pose = [posture.rest], posture.rest
    for goal in goals:
        pose, _ = posture.towards(posture.rest, goal)
        poses.append(pose)
    return poses
