"""A robot's acceleration and its derivatives along a motion."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.fluid.kernel import flowing

NUDGE = 1e-5
"""Step of the central differences, rad or m, and per s. Accelerations near 100 per s2 round to
1e-14, an error of 1e-9 in a derivative; truncation adds 1e-10 / 6 of the third derivative."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Linearisation:
    """A model's acceleration along a motion, to first order in state and generalized force."""

    acceleration: Array
    """Of the model at the motion's states and commands, rad/s2 or m/s2, shape (samples, dofs)."""
    jacobian: Array
    """[dqacc/dq, dqacc/dv, M^-1], shape (samples, dofs, 3 dofs)."""


def linearised(
    model: mujoco.MjModel, position: Array, velocity: Array, command: Array, *, every: int = 4
) -> Linearisation:
    """Return a model's acceleration along a motion of hinges and slides, and its derivatives.

    Constraints are left out: dry friction, stops and contacts are laws of their own. Derivatives
    are central differences at every few samples, linearly interpolated between these.

    Args:
        model: The model; its state has a position for each degree of freedom.
        position: rad or m, shape (samples, dofs).
        velocity: Per s, same shape.
        command: Controls, shape (samples, actuators).
        every: Samples from one derivative to the next.
    """
    samples, dofs = position.shape
    data = mujoco.MjData(model)
    keys = np.unique(np.append(np.arange(0, samples, every), samples - 1))
    jacobians = np.empty((len(keys), dofs, 3 * dofs))
    with _unconstrained(model):
        for at, t in enumerate(keys):
            data.qpos[:], data.qvel[:], data.ctrl[:] = position[t], velocity[t], command[t]
            jacobians[at] = _jacobian(model, data)
    place = np.interp(np.arange(samples), keys, np.arange(len(keys)))
    low = np.minimum(place.astype(int), max(len(keys) - 2, 0))
    share = (place - low)[:, None, None]
    high = np.minimum(low + 1, len(keys) - 1)
    jacobian = (1.0 - share) * jacobians[low] + share * jacobians[high]
    found = accelerations(model, position, velocity, command)
    return Linearisation(acceleration=found, jacobian=jacobian)


def accelerations(model: mujoco.MjModel, position: Array, velocity: Array, command: Array) -> Array:
    """Return a model's acceleration along a motion, per s2, shape (samples, dofs).

    Constraints are left out.

    Args:
        model: The model; its state has a position for each degree of freedom.
        position: rad or m, shape (samples, dofs).
        velocity: Per s, same shape.
        command: Controls, shape (samples, actuators).
    """
    data, found = mujoco.MjData(model), np.empty_like(position)
    with _unconstrained(model):
        for t in range(len(position)):
            data.qpos[:], data.qvel[:], data.ctrl[:] = position[t], velocity[t], command[t]
            mujoco.mj_forward(model, data)
            found[t] = data.qacc
    return found


def supplied(
    model: mujoco.MjModel, position: Array, velocity: Array, acceleration: Array, command: Array
) -> Array:
    """Return the actuators' force less that which a motion needs, N m or N, (samples, dofs).

    It is zero along a motion of the model itself. Constraints are left out.

    Args:
        model: The model; its state has a position for each degree of freedom.
        position: rad or m, shape (samples, dofs).
        velocity: Per s, same shape.
        acceleration: Per s2, same shape.
        command: Controls, shape (samples, actuators).
    """
    data, force = mujoco.MjData(model), np.empty_like(position)
    with _unconstrained(model):
        for t in range(len(position)):
            data.qpos[:], data.qvel[:] = position[t], velocity[t]
            data.qacc[:], data.ctrl[:] = acceleration[t], command[t]
            mujoco.mj_inverse(model, data)
            mujoco.mj_fwdActuation(model, data)
            force[t] = data.qfrc_actuator - data.qfrc_inverse
    return force


@contextmanager
def _unconstrained(model: mujoco.MjModel) -> Iterator[None]:
    """Disable a model's constraints and enable its fluid, as long as this lasts."""
    flags = model.opt.disableflags
    model.opt.disableflags = flags | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT.value
    try:
        with flowing(model):
            yield
    finally:
        model.opt.disableflags = flags


def _jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return [dqacc/dq, dqacc/dv, M^-1] at the state in `data`, shape (dofs, 3 dofs)."""
    dofs = model.nv
    found = np.empty((dofs, 3 * dofs))
    for block, values in enumerate((data.qpos, data.qvel)):
        for dof in range(dofs):
            kept = values[dof]
            values[dof] = kept + NUDGE
            mujoco.mj_forward(model, data)
            above = data.qacc.copy()
            values[dof] = kept - NUDGE
            mujoco.mj_forward(model, data)
            found[:, block * dofs + dof] = (above - data.qacc) / (2.0 * NUDGE)
            values[dof] = kept
    mujoco.mj_forward(model, data)
    inverse = np.empty((dofs, dofs))
    mujoco.mj_solveM(model, data, inverse, np.eye(dofs))
    found[:, 2 * dofs :] = inverse
    return found
