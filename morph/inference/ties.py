"""Joints that follow others along a motion: their place, and who bears their forces."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.follow import chains, leaders

HELD = 1e-7
"""Mobility along a direction, in units of the degrees' own, below which constraints hold it."""


def inverse(model: mujoco.MjModel, mobility: Array) -> Array:
    """Return the inertia by a mobility, (samples, dofs, dofs).

    Where joints follow others or chains are closed it is a generalized inverse: it tells the least
    force, over the roots of the degrees' own mobilities, of those that do the same.
    """
    if not leaders(model) and not chains(model):
        return np.asarray(np.linalg.inv(mobility))
    size = 1.0 / np.sqrt(np.einsum("tii->ti", mobility))
    both = size[:, :, None] * size[:, None, :]
    return np.asarray(both * np.linalg.pinv(both * mobility, rcond=HELD, hermitian=True))


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
