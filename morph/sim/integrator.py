"""Which integrator a simulation steps with."""

from __future__ import annotations

from typing import Literal

import mujoco
import numpy as np

from morph.physics.fluid.kernel import flowing
from morph.physics.fluid.numbers import ADDED, DISPLACED, LINEAR, QUADRATIC, SHED
from morph.physics.fluid.reference import wet_bodies
from morph.physics.motion import actuator_moments

Integrator = Literal["implicitfast", "rk4"]
"""`implicitfast` bears contacts and stiff joints; `rk4` keeps the energy of free motion."""

INTEGRATORS = {
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "rk4": mujoco.mjtIntegrator.mjINT_RK4,
}

MARGIN = 1.0
"""Greatest rate of the joints' springs and dampers by the step; RK4 is stable up to 2.7."""


def best_integrator(model: mujoco.MjModel) -> Integrator:
    """Return `rk4` for a body that moves freely in a fluid, else `implicitfast`.

    In a fluid implicitfast is of first order: a body that tumbles without drag gains a tenth
    of its energy in 5 s at 2 ms. RK4 is of fourth order, and four times slower. It bears no
    contact, no closed chain, no dry friction, and no joint that is stiff for the step.
    """
    free = _feels_a_fluid(model) and model.neq == 0 and not model.dof_frictionloss.any()
    return "rk4" if free and not _may_touch(model) and not _stiff(model) else "implicitfast"


def is_smooth(model: mujoco.MjModel) -> bool:
    """Return whether nothing ever jerks: no contact, closed chain, limit, dry or stiff joint.

    Such a body RK4 moves best, at several times the step that implicitfast would need.
    """
    held = model.neq or model.jnt_limited.any() or model.tendon_limited.any()
    jerks = held or model.dof_frictionloss.any() or _may_touch(model) or _stiff(model)
    return not bool(jerks)


def _stiff(model: mujoco.MjModel) -> bool:
    return bool(_fastest(model) * model.opt.timestep >= MARGIN)


def _feels_a_fluid(model: mujoco.MjModel) -> bool:
    """Return whether a fluid does anything: an effect at its neutral value writes zeros."""
    in_fluid = model.body_user[wet_bodies(model)]
    acting = (ADDED, DISPLACED, LINEAR, QUADRATIC, SHED)
    return any(bool(in_fluid[:, where].any()) for where in acting)


def _may_touch(model: mujoco.MjModel) -> bool:
    if model.npair:
        return True
    kind, answer = model.geom_contype, model.geom_conaffinity
    met = (kind[:, None] & answer[None]) | (kind[None] & answer[:, None])
    bodies = model.geom_bodyid
    return bool(met[bodies[:, None] != bodies[None]].any())


def _fastest(model: mujoco.MjModel) -> float:
    """Return the fastest rate at which springs, dampers and servos act on the joints, 1/s."""
    data = mujoco.MjData(model)
    with flowing(model):
        mujoco.mj_forward(model, data)
    inertia = np.empty((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    damping = np.diag(model.dof_damping).astype(float)
    stiffness = np.zeros_like(damping)
    for joint in range(model.njnt):
        at = model.jnt_dofadr[joint]
        stiffness[at, at] += model.jnt_stiffness[joint].flat[0]
    for servo, row in enumerate(actuator_moments(model, data)):
        stiffness += max(-model.actuator_biasprm[servo, 1], 0.0) * np.outer(row, row)
        damping += max(-model.actuator_biasprm[servo, 2], 0.0) * np.outer(row, row)
    damped = np.abs(np.linalg.eigvals(np.linalg.solve(inertia, damping))).max(initial=0.0)
    sprung = np.abs(np.linalg.eigvals(np.linalg.solve(inertia, stiffness))).max(initial=0.0)
    return float(max(damped, np.sqrt(sprung)))
