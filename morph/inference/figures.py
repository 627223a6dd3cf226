"""Generalized forces of a change in a description's own figures: masses, gains, joint constants."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.body.inertial import pull, spatial, steiner
from morph.physics.motion import Motion

DRIVES = (
    "actuator_gear", "actuator_gainprm", "actuator_biasprm", "actuator_forcerange",
    "jnt_actfrcrange",
)  # fmt: skip
"""What a model says of its actuators' forces."""


def forces_between(one: mujoco.MjModel, others: Sequence[mujoco.MjModel], motion: Motion) -> Array:
    """Return the force that a motion lacks in one model and has in others.

    The models may differ in mass, centre and inertia of links, in gains of actuators, and in
    damping, armature and stiffness of hinges and slides. Nothing is simulated.

    Args:
        one: A model.
        others: Others of the same robot.
        motion: Positions, velocities, accelerations, commands, and how links move.

    Returns:
        N m or N, shape (samples, dofs, others).
    """
    force = np.zeros((*motion.position.shape, len(others)))
    base = None
    for at, other in enumerate(others):
        if not all(np.array_equal(getattr(one, name), getattr(other, name)) for name in DRIVES):
            base = driven(one, motion) if base is None else base
            force[:, :, at] = driven(other, motion) - base
        damping = other.dof_damping.reshape(-1) - one.dof_damping.reshape(-1)
        if damping.any():
            force[:, :, at] -= damping * motion.velocity
        armature = other.dof_armature - one.dof_armature
        if armature.any():
            force[:, :, at] -= armature * motion.acceleration
        force[:, :, at] += _spring(other, motion) - _spring(one, motion)
    for name, body in motion.bodies.items():
        before = _inertia(one, name)
        changes = [_inertia(other, name) - before for other in others]
        changed = [at for at, change in enumerate(changes) if change.any()]
        if changed:
            force[:, :, changed] += pull(body, [changes[at] for at in changed])
    return force


def _inertia(model: mujoco.MjModel, name: str) -> Array:
    """Return the spatial inertia of a link about its origin, shape (6, 6)."""
    body, turn = model.body(name).id, np.empty(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    axes, mass, com = turn.reshape(3, 3), float(model.body_mass[body]), model.body_ipos[body]
    about_com = axes @ np.diag(model.body_inertia[body]) @ axes.T
    return spatial(mass, mass * com, about_com + mass * steiner(com, com))


def driven(model: mujoco.MjModel, motion: Motion) -> Array:
    """Return the actuators' generalized forces within their limits, N m or N, (samples, dofs)."""
    force = actuator_forces(model, motion.position, motion.velocity, motion.command)
    force = force @ constant_moments(model)
    return _clamped(force, model.jnt_actfrclimited, model.jnt_actfrcrange)


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
    force = gain * _clamped(command, model.actuator_ctrllimited, model.actuator_ctrlrange)
    force += bias[:, 0] + bias[:, 1] * (position @ moments.T)
    force += bias[:, 2] * (velocity @ moments.T)
    return _clamped(force, model.actuator_forcelimited, model.actuator_forcerange)


def constant_moments(model: mujoco.MjModel) -> Array:
    """Return the actuators' moments, shape (actuators, dofs).

    They are the same everywhere: actuators pull on hinges and slides, not on tendons.
    """
    moments = np.zeros((model.nu, model.nv))
    dofs = model.jnt_dofadr[model.actuator_trnid[:, 0]]
    moments[np.arange(model.nu), dofs] = model.actuator_gear[:, 0]
    return moments


def _clamped(values: Array, limited: Array, ranges: Array) -> Array:
    low = np.where(limited, ranges[:, 0], -np.inf)
    return np.clip(values, low, np.where(limited, ranges[:, 1], np.inf))


def _spring(model: mujoco.MjModel, motion: Motion) -> Array:
    stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[:, 0]
    return np.asarray(-stiffness * (motion.position - model.qpos_spring))
