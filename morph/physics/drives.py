"""Forces of actuators along a motion."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array


def actuator_forces(
    model: mujoco.MjModel, position: Array, velocity: Array, command: Array
) -> Array:
    """Return the actuators' own forces within their limits, shape (samples, actuators).

    Args:
        model: The model; its actuators have no activation of their own.
        position: rad or m, shape (samples, dofs).
        velocity: Per s, same shape.
        command: Controls, shape (samples, actuators).
    """
    moments = constant_moments(model)
    gain, bias = model.actuator_gainprm[:, 0], model.actuator_biasprm
    force = gain * clamped(command, model.actuator_ctrllimited, model.actuator_ctrlrange)
    force += bias[:, 0] + bias[:, 1] * (position @ moments.T)
    force += bias[:, 2] * (velocity @ moments.T)
    return clamped(force, model.actuator_forcelimited, model.actuator_forcerange)


def constant_moments(model: mujoco.MjModel) -> Array:
    """Return the actuators' moments, shape (actuators, dofs).

    They are the same everywhere: actuators pull on hinges and slides, not on tendons.
    """
    moments = np.zeros((model.nu, model.nv))
    dofs = model.jnt_dofadr[model.actuator_trnid[:, 0]]
    moments[np.arange(model.nu), dofs] = model.actuator_gear[:, 0]
    return moments


def clamped(values: Array, limited: Array, ranges: Array) -> Array:
    """Return values within their ranges, where they are limited."""
    low = np.where(limited, ranges[:, 0], -np.inf)
    return np.clip(values, low, np.where(limited, ranges[:, 1], np.inf))
