"""Generalized forces of a change in own parameters: masses, gains, constants of joints."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.body.inertial import pull, spatial, steiner
from morph.physics.drives import Transmission, actuator_forces, clamped
from morph.physics.motion import Motion
from morph.sim.tangent import HINGE, SLIDE

DRIVES = (
    "actuator_gear", "actuator_gainprm", "actuator_biasprm", "actuator_forcerange",
    "jnt_actfrcrange",
)  # fmt: skip
"""What a model says of its actuators' forces."""
LINKS = ("body_mass", "body_ipos", "body_inertia", "body_iquat")
"""And of its links' inertia."""


def forces_between(one: mujoco.MjModel, others: Sequence[mujoco.MjModel], motion: Motion) -> Array:
    """Return the force that a motion lacks in one model and has in others.

    The models may differ in mass, centre and inertia of links, in gains of actuators, and in
    damping, armature, dry friction and stiffness of hinges and slides. Nothing is simulated.

    Args:
        one: A model.
        others: Others of the same robot.
        motion: Positions, velocities, accelerations, commands, and how links move.

    Returns:
        N m or N, shape (samples, dofs, others).
    """
    force = np.zeros((*motion.position.shape, len(others)))
    base, spring = None, _spring(one, motion)
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
        friction = other.dof_frictionloss - one.dof_frictionloss
        for joint, dof in motion.joints.items():
            if friction[dof]:
                force[:, dof, at] -= friction[dof] * motion.sign(joint)
        force[:, :, at] += _spring(other, motion) - spring
    for name, body in motion.bodies.items():
        link, before = one.body(name).id, _inertia(one, name)
        changed = [
            at
            for at, other in enumerate(others)
            if any((getattr(one, each)[link] != getattr(other, each)[link]).any() for each in LINKS)
        ]
        if changed:
            changes = [_inertia(others[at], name) - before for at in changed]
            force[:, :, changed] += pull(body, changes)
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
    transmission = Transmission.along(model, motion.qpos)
    own = actuator_forces(model, transmission, motion.velocity, motion.command)
    force = transmission.forces(own)
    joint = model.dof_jntid
    return clamped(force, model.jnt_actfrclimited[joint], model.jnt_actfrcrange[joint])


def _spring(model: mujoco.MjModel, motion: Motion) -> Array:
    joints = np.flatnonzero(np.isin(model.jnt_type, (HINGE, SLIDE)))
    stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[joints, 0]
    dofs, rest = model.jnt_dofadr[joints], model.qpos_spring[model.jnt_qposadr[joints]]
    force = np.zeros_like(motion.position)
    force[:, dofs] = -stiffness * (motion.position[:, dofs] - rest)
    return force
