"""Poses within the limits of a robot's joints."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array

SCALAR = (mujoco.mjtJoint.mjJNT_SLIDE.value, mujoco.mjtJoint.mjJNT_HINGE.value)


def within_limits(model: Any, pose: Array) -> Array:
    """Return the nearest pose with every limited hinge and slide in its range.

    Args:
        model: The `mujoco.MjModel`.
        pose: `qpos`, shape (nq,); it is not changed.
    """
    result = np.array(pose)
    for joint in np.flatnonzero(model.jnt_limited):
        if model.jnt_type[joint] in SCALAR:
            at = int(model.jnt_qposadr[joint])
            result[at] = np.clip(result[at], *model.jnt_range[joint])
    return result
