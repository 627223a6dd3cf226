"""Damping by the trapezoidal rule, within MuJoCo's implicit step."""

from __future__ import annotations

import copy
from dataclasses import replace

import mujoco
import numpy as np

from morph.body.actuators import driven_joint
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.sim.rollout import Variant

MOST = 0.25
"""Most share of a joint's inertia that is taken: joints may be lighter in other postures."""


def trapezoidal(variant: Variant) -> Variant:
    """Return a simulation of which damping errs by the second order of a step, not the first.

    MuJoCo's implicit step solves (M + h D) dv = h tau, D the damping of joints and servos, as
    Euler's backward rule does. With M - h D / 2 in the place of M it is (M + h D / 2) dv = h tau,
    the trapezoidal rule. What is taken is an armature. Nothing is taken for motors whose force is
    limited, by themselves or by their joint, as MuJoCo leaves out their damping at the limit, nor
    for those that turn a rotor on a spring.

    Source: Hairer, Norsett and Wanner 1993, Solving ordinary differential equations I, section
    II.7 (the trapezoidal rule); the MuJoCo documentation, chapter Computation, section Numerical
    integration (the implicit step).

    Args:
        variant: What is simulated; it stays as it is.
    """
    model = copy.copy(variant.model)
    damping = model.dof_damping.copy()
    servo = model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE
    for motor in np.flatnonzero(servo & (model.actuator_forcelimited == 0)):
        turned = driven_joint(model, int(motor))
        if turned is None or model.jnt_actfrclimited[turned]:
            continue
        dof = model.jnt_dofadr[turned]
        damping[dof] -= model.actuator_gear[motor, 0] ** 2 * model.actuator_biasprm[motor, 2]
    for effect in variant.effects:
        if isinstance(effect, SeriesElasticity):
            damping[model.joint(effect.joint).dofadr[0]] = 0.0
    root = np.sqrt(0.5 * model.opt.timestep * np.maximum(damping, 0.0))
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    inverse = np.zeros((model.nv, model.nv))
    mujoco.mj_solveM(model, data, inverse, np.diag(root))
    # The largest share of inertia along any motion of the joints.
    share = float(np.linalg.eigvalsh(root[:, None] * inverse).max(initial=0.0))
    taken = root**2 * min(1.0, MOST / max(share, MOST))
    model.dof_armature -= taken
    # Of a joint whose inertia is constant MuJoCo reads it here.
    model.dof_M0 -= taken
    return replace(variant, model=model)
