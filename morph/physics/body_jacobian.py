"""The Jacobian of a point of a body in the body's own axes."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array


def jacobian_of(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, point: Array
) -> tuple[Array, Array]:
    """Return J and dJ/dt of a point of a body, in the body's axes, linear rows first.

    Args:
        model: The compiled robot.
        data: Its state, positions and velocities passed forward.
        body: The body's index.
        point: The point in the body's frame, m.

    Returns:
        Two matrices of shape (6, nv): J v are the components of the velocity, and their
        rate is J dv/dt + dJ/dt v.
    """
    turned = data.xmat[body].reshape(3, 3)
    spot = data.xpos[body] + turned @ point
    linear, angular = np.zeros((2, 3, model.nv))
    mujoco.mj_jac(model, data, linear, angular, spot, body)
    linear_rate, angular_rate = np.zeros((2, 3, model.nv))
    mujoco.mj_jacDot(model, data, linear_rate, angular_rate, spot, body)
    # In the body's axes R' x changes by R' (dx/dt - w x x).
    spin = cross_matrix(angular @ data.qvel)
    jacobian = np.vstack([turned.T @ linear, turned.T @ angular])
    rate = np.vstack(
        [turned.T @ (linear_rate - spin @ linear), turned.T @ (angular_rate - spin @ angular)]
    )
    return jacobian, rate


def cross_matrix(x: Array) -> Array:
    """Return what multiplies by x from the left as the cross product does, shape (..., 3, 3)."""
    result = np.zeros((*np.shape(x), 3))
    result[..., 2, 1], result[..., 0, 2], result[..., 1, 0] = np.moveaxis(np.asarray(x), -1, 0)
    return result - np.swapaxes(result, -1, -2)
