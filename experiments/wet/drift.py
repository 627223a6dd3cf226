"""How well the energy of a body and its fluid is kept."""

from __future__ import annotations

import mujoco
import numpy as np

from experiments.wet.trees import random_tree
from morph.physics.fluid.numbers import CENTRE, DISPLACED

SPEED = 0.5
"""Root mean square of every start velocity, m/s and rad/s."""


KINDS = ("in a fluid", "in a fluid, with weight and lift", "dry")
"""What may surround a tree: the last is the control, what RK4 itself loses."""


def drift(
    bodies: int, seed: int, kind: str = KINDS[0], *, step: float = 0.005, seconds: float = 5.0
) -> float:
    """Return the greatest change of energy of a random tree by its kinetic energy at the start."""
    rng = np.random.default_rng([seed, bodies])
    model = random_tree(bodies, rng, step=step)
    if kind != KINDS[1]:
        model.opt.gravity[:] = 0.0
    if kind == KINDS[2]:
        model.body_user[:] = 0.0
    data = mujoco.MjData(model)
    data.qvel[:] = SPEED * rng.normal(size=model.nv)
    energies = [_energy(model, data)]
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
        energies.append(_energy(model, data))
    total, kinetic = np.array(energies).T
    return float(np.abs(total - total[0]).max() / kinetic[0])


def _energy(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[float, float]:
    """Return the energy of body and fluid, and how much of it is kinetic, J."""
    mujoco.mj_forward(model, data)
    momentum = np.empty(model.nv)
    mujoco.mj_mulM(model, data, momentum, data.qvel)
    kinetic = 0.5 * float(data.qvel @ momentum)
    turned = data.xmat.reshape(-1, 3, 3)
    lifted = data.xpos + np.einsum("bij,bj->bi", turned, model.body_user[:, CENTRE])
    weight = model.body_mass @ data.xipos - model.body_user[:, DISPLACED][:, 0] @ lifted
    return kinetic - float(weight @ model.opt.gravity), kinetic
