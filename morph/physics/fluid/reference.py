"""The fluid of kernel.c in readable numpy: its oracle in the tests, and what runs without it."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array, Integers
from morph.physics.body_jacobian import jacobian_of
from morph.physics.fluid.numbers import (
    ADDED,
    APART,
    CENTRE,
    CHORD,
    CURRENT,
    DISPLACED,
    EDGE,
    FEWER,
    LINEAR,
    NORMAL,
    POINT,
    QUADRATIC,
    SCALE,
    SHED,
    SIGNATURE,
    WIDTH,
)

WETTED = 1.0
"""What marks in `crb` of the world that M holds the fluid; MuJoCo clears it with every new M."""


def passive(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Add the fluid's inertia to `data.M` and its forces to `data.qfrc_passive`.

    Every wet body has a dense Jacobian here, J (6, nv), of its point of reference in its own
    axes. With u = J v the velocity through the fluid, K the added mass, p = K u:

        M += J' K J,    qfrc_passive += J' (f - K dJ/dt v - [w x p; w x h + v x p])

    Source: Kirchhoff's equations, Lamb 1932, section 124; thesis eq. 7.
    """
    wet = wet_bodies(model)
    if not len(wet):
        return
    inertia = np.zeros((model.nv, model.nv))
    for body in wet:
        numbers = model.body_user[body]
        jacobian, rate = jacobian_of(model, data, int(body), numbers[POINT])
        added = numbers[SCALE] * tensor(numbers[ADDED])
        inertia += jacobian.T @ added @ jacobian
        moving, slope = through_fluid(data, int(body), jacobian, rate, numbers[CURRENT])
        load = -added @ slope - gyroscopic(moving, added @ moving)
        load -= numbers[SCALE] * numbers[LINEAR] * moving
        data.qfrc_passive[:] += jacobian.T @ load
        data.qfrc_passive[:] += _quadratic_drag(model, data, int(body))
        data.qfrc_passive[:] += _buoyancy(model, data, int(body), numbers)
        data.qfrc_passive[:] += _thrust(model, data, int(body))
    if data.crb[0, 0] != WETTED:
        _add_to_inertia(model, data, inertia)


def wet_bodies(model: mujoco.MjModel) -> Integers:
    """Return the indices of the bodies that feel the fluid."""
    if model.nuser_body < FEWER:
        return np.zeros(0, dtype=np.int64)
    user = model.body_user
    return np.flatnonzero((user[:, 0] == SIGNATURE) & (user[:, SCALE][:, 0] != 0.0))


def tensor(upper: Array) -> Array:
    """Return the symmetric matrix (6, 6) whose upper triangle is given row by row, (21,)."""
    whole = np.zeros((6, 6))
    whole[np.triu_indices(6)] = upper
    return np.asarray(whole + np.triu(whole, 1).T)


def through_fluid(
    data: mujoco.MjData, body: int, jacobian: Array, rate: Array, current: Array
) -> tuple[Array, Array]:
    """Return velocity and joint-free acceleration through a fluid that itself moves, (6,) each."""
    moving, slope = jacobian @ data.qvel, rate @ data.qvel
    stream = data.xmat[body].reshape(3, 3).T @ current
    # A steady stream turns, seen from the body, by minus the body's own rotation.
    slope[:3] += np.cross(moving[3:], stream)
    moving[:3] -= stream
    return moving, slope


def gyroscopic(moving: Array, momentum: Array) -> Array:
    """Return [w x p; w x h + v x p] of a velocity (v, w) and a momentum (p, h), (6,)."""
    linear, angular = np.split(moving, 2)
    push, spin = np.split(momentum, 2)
    return np.concatenate(
        [np.cross(angular, push), np.cross(angular, spin) + np.cross(linear, push)]
    )


def squared(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Array, Array]:
    """Return the Jacobian (6, nv) of the point of a link's quadratic drag, and that drag, (6,)."""
    numbers = model.body_user[body]
    apart = numbers[APART] if len(numbers) >= WIDTH else 0.0
    jacobian, rate = jacobian_of(model, data, body, numbers[POINT] + apart)
    moving, _ = through_fluid(data, body, jacobian, rate, numbers[CURRENT])
    return jacobian, -numbers[SCALE] * numbers[QUADRATIC] * abs(moving) * moving


def _quadratic_drag(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Array:
    jacobian, load = squared(model, data, body)
    return np.asarray(jacobian.T @ load)


def _buoyancy(model: mujoco.MjModel, data: mujoco.MjData, body: int, numbers: Array) -> Array:
    enabled = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    jacobian = np.zeros((3, model.nv))
    spot = data.xpos[body] + data.xmat[body].reshape(3, 3) @ numbers[CENTRE]
    mujoco.mj_jac(model, data, jacobian, None, spot, body)
    lift = -float(enabled * numbers[SCALE][0] * numbers[DISPLACED][0]) * model.opt.gravity
    return np.asarray(jacobian.T @ lift)


def _thrust(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Array:
    """Return what leaves at the trailing edge as a generalized force, (nv,)."""
    jacobian, load = shed(model, data, body)
    return np.asarray(jacobian.T @ load)


def shed(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Array, Array]:
    """Return the Jacobian (3, nv) of a body's trailing edge and the force there, N, shape (3,).

    Source: Lighthill 1971, as `thrust.tail_force`.
    """
    numbers, turned = model.body_user[body], data.xmat[body].reshape(3, 3)
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, data.xpos[body] + turned @ numbers[EDGE], body)
    velocity = jacobian @ data.qvel - numbers[CURRENT]
    chord, normal = turned @ numbers[CHORD], turned @ numbers[NORMAL]
    along, across = velocity @ chord, velocity @ normal
    mass = float(numbers[SCALE][0] * numbers[SHED][0])
    load = mass * across * (0.5 * across * chord - max(along, 0.0) * normal)
    return jacobian, np.asarray(load)


def _add_to_inertia(model: mujoco.MjModel, data: mujoco.MjData, inertia: Array) -> None:
    for row in range(model.nv):
        first, count = model.M_rowadr[row], model.M_rownnz[row]
        data.M[first : first + count] += inertia[row, model.M_colind[first : first + count]]
    data.crb[0, 0] = WETTED
    mujoco.mj_factorM(model, data)
