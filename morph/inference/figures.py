"""Generalized forces by which a description's own figures change its motion."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.body.inertial import pull, spatial, steiner
from morph.physics.motion import Motion, actuator_moments


def force_between(one: mujoco.MjModel, other: mujoco.MjModel, motion: Motion) -> Array:
    """Return how much more force acts on a motion in another model, shape (samples, dofs).

    The models may differ in what links weigh and how they turn, in the gains of actuators, and in
    damping, armature and stiffness of hinges and slides; nothing is simulated.

    Args:
        one: A model.
        other: Another of the same robot.
        motion: Positions, velocities, accelerations, commands, and how links move.
    """
    force = driven(other, motion) - driven(one, motion)
    force -= (other.dof_damping.reshape(-1) - one.dof_damping.reshape(-1)) * motion.velocity
    force -= (other.dof_armature - one.dof_armature) * motion.acceleration
    force += _sprung(other, motion) - _sprung(one, motion)
    for name, body in motion.bodies.items():
        change = _inertia(other, name) - _inertia(one, name)
        if change.any():
            force += pull(body, [change])[:, :, 0]
    return force


def _inertia(model: mujoco.MjModel, name: str) -> Array:
    """Return the spatial inertia of a link about its origin, shape (6, 6)."""
    body, axes = model.body(name).id, np.empty(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[body])
    turned, mass, com = axes.reshape(3, 3), float(model.body_mass[body]), model.body_ipos[body]
    about_com = turned @ np.diag(model.body_inertia[body]) @ turned.T
    return spatial(mass, mass * com, about_com + mass * steiner(com, com))


def driven(model: mujoco.MjModel, motion: Motion) -> Array:
    """Return the generalized forces of actuators on joints, within their limits."""
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    moments = actuator_moments(model, data)
    gain, bias = model.actuator_gainprm[:, 0], model.actuator_biasprm
    force = gain * _within(motion.command, model.actuator_ctrllimited, model.actuator_ctrlrange)
    force += bias[:, 0] + bias[:, 1] * (motion.position @ moments.T)
    force += bias[:, 2] * (motion.velocity @ moments.T)
    force = _within(force, model.actuator_forcelimited, model.actuator_forcerange)
    return _within(force @ moments, model.jnt_actfrclimited, model.jnt_actfrcrange)


def _within(values: Array, limited: Array, ranges: Array) -> Array:
    low = np.where(limited, ranges[:, 0], -np.inf)
    return np.clip(values, low, np.where(limited, ranges[:, 1], np.inf))


def _sprung(model: mujoco.MjModel, motion: Motion) -> Array:
    stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[:, 0]
    return np.asarray(-stiffness * (motion.position - model.qpos_spring))
