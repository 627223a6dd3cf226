"""The force of the water on each link: what the kernel gives to MuJoCo, told link by link."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.body_jacobian import jacobian_of
from morph.physics.fluid.numbers import (
    ADDED,
    CENTRE,
    CURRENT,
    DISPLACED,
    LINEAR,
    POINT,
    SCALE,
)
from morph.physics.fluid.reference import (
    gyroscopic,
    shed,
    squared,
    tensor,
    through_fluid,
    wet_bodies,
)


def water_forces(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return where water presses on each wet link and how, world axes, m and N.

    Shape (2, wet links, 2, 3): first drag, thrust and the resistance of the water that the link
    carries along, at the link's centre of mass; then buoyancy, at its centre of buoyancy. With
    `reference.passive`'s symbols the first is f - K (J a + dJ/dt v) - w x p, its linear part.

    Args:
        model: The compiled model.
        data: A state passed forward, accelerations included.
    """
    wet = wet_bodies(model)
    result = np.zeros((2, len(wet), 2, 3))
    on = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    for row, body in enumerate(wet.tolist()):
        numbers = model.body_user[body]
        scale, turned = float(numbers[SCALE][0]), data.xmat[body].reshape(3, 3)
        result[0, row] = data.xipos[body], _moving(model, data, body)
        result[1, row, 0] = data.xpos[body] + turned @ numbers[CENTRE]
        result[1, row, 1] = -float(on) * scale * float(numbers[DISPLACED][0]) * model.opt.gravity
    return result


def _moving(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Array:
    """Return the force, N, shape (3,), that would vanish if link and water were at rest."""
    numbers = model.body_user[body]
    scale, turned = float(numbers[SCALE][0]), data.xmat[body].reshape(3, 3)
    jacobian, rate = jacobian_of(model, data, body, numbers[POINT])
    added = scale * tensor(numbers[ADDED])
    moving, slope = through_fluid(data, body, jacobian, rate, numbers[CURRENT])
    load = -added @ (jacobian @ data.qacc + slope) - gyroscopic(moving, added @ moving)
    load -= scale * numbers[LINEAR] * moving - squared(model, data, body)[1]
    return np.asarray(turned @ load[:3] + shed(model, data, body)[1])
