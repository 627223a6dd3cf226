"""Each joint in turn through its range: how a body can move, before anything drives it."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.body.posture import Posture

SECONDS = 5.0
"""How long all joints take together, if nothing else is said."""

LEAST = 1.25
"""How long one joint takes at least, s, if there is so much time: joints then overlap."""

MADE_UP = 0.2
"""Part of a range that is shown where it is made up, as a slide's without limits is: a cart
stays on its rail, less than half of the body's extent from where it rests."""


def swept(posture: Posture, seconds: float = SECONDS) -> tuple[Array, bool]:
    """Return poses in which each joint goes to its one end, to the other and back.

    Args:
        posture: The poses that the body can take: what follows another joint or closes a loop
            follows here, too.
        seconds: How long it takes.

    Returns:
        `qpos` in each picture, shape (pictures, nq), and whether every joint went as far as its
        limits; a loop may stop it before.
    """
    pictures = max(2, round(seconds * RATE) + 1)
    goals = _goals(posture, np.arange(pictures) / (pictures - 1))
    poses = np.empty((pictures, len(posture.rest)))
    pose, whole = posture.rest, True
    for at, goal in enumerate(goals):
        pose, arrived = posture.towards(pose, goal)
        poses[at] = pose
        whole &= arrived
    return poses, whole


def _goals(posture: Posture, share: Array) -> Array:
    """Return where each handle is when a share of the time has passed, (pictures, handles)."""
    handles = posture.handles
    goals = np.tile([handle.rest for handle in handles], (len(share), 1))
    base = base_joints(posture.model)
    moving = [at for at, handle in enumerate(handles) if handle.joint not in base]
    for turn, at in enumerate(moving):
        handle = handles[at]
        # The later a joint is in the chain, the later it begins; with many joints they overlap.
        wide = max(1.0 / len(moving), min(1.0, LEAST / SECONDS))
        begins = (1.0 - wide) * turn / max(1, len(moving) - 1)
        part = np.clip((share - begins) / wide, 0.0, 1.0)
        reach = 1.0 if handle.ranged else MADE_UP
        high, low = (handle.rest + reach * (end - handle.rest) for end in (handle.high, handle.low))
        goals[:, at] = np.interp(
            _eased(part), [0.0, 1.0, 2.0, 3.0], [handle.rest, high, low, handle.rest]
        )
    return goals


def base_joints(model: Any) -> set[str]:
    """Return the joints that only let a body float in a plane, such as a biped's own place.

    They are several joints of one link that hangs from the world, none of them driven: to show
    their range would show the body somewhere else, not what it can do.
    """
    joint = mujoco.mjtTrn.mjTRN_JOINT.value
    driven = {
        int(model.actuator_trnid[at, 0])
        for at in range(model.nu)
        if model.actuator_trntype[at] == joint
    }
    results: set[str] = set()
    for link in range(1, model.nbody):
        first, count = int(model.body_jntadr[link]), int(model.body_jntnum[link])
        own = range(first, first + count)
        if model.body_parentid[link] == 0 and count > 1 and not driven.intersection(own):
            results.update(model.joint(at).name for at in own)
    return results


def _eased(part: Array) -> Array:
    """Return how far along its three ways a joint is, 0 to 3; it rests where it turns."""
    way = np.minimum(np.floor(3.0 * part), 2.0)
    within = 3.0 * part - way
    return np.asarray(way + 0.5 - 0.5 * np.cos(np.pi * within))
