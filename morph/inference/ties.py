"""Joints that follow others along a motion: their place, and who bears their forces."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.follow import leaders


def inverse(model: mujoco.MjModel, mobility: Array) -> Array:
    """Return the inertia by a mobility, (samples, dofs, dofs); a pseudoinverse if joints follow."""
    return np.asarray(np.linalg.pinv(mobility) if leaders(model) else np.linalg.inv(mobility))


def carried(model: mujoco.MjModel, force: Array) -> Array:
    """Return forces of which each joint bears those of what follows it, (samples, dofs).

    A follower's is what would do the same there.
    """
    whole, ties = force.copy(), leaders(model)
    dof = model.jnt_dofadr
    for joint, (leader, ratio, _) in ties.items():
        whole[:, dof[leader]] += ratio * force[:, dof[joint]]
    for joint, (leader, ratio, _) in ties.items():
        whole[:, dof[joint]] = whole[:, dof[leader]] / ratio
    return whole
