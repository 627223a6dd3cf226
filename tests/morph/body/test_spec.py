"""What MuJoCo computes for the shelf's bodies, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of


def mass_matrix(model: Any, position: Array) -> Array:
    """Return the mass matrix at a position, shape (dof, dof)."""
    data = mujoco.MjData(model)
    data.qpos[:] = position
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


def test_an_edit_of_one_spec_does_not_reach_the_next() -> None:
    robot = load("pendulum")
    spec_of(robot).joint("hinge").damping = np.array([1.0, 0.0, 0.0])
    assert spec_of(robot).compile().dof_damping[0] == 0.0


@pytest.mark.parametrize("timestep", [0.0005, 0.001, 0.002, 0.005])
def test_a_joint_that_friction_holds_does_not_creep(timestep: float) -> None:
    # Gravity: 1 kg * 9.81 m/s^2 * 0.5 m * sin(0.05) = 0.245 N m, below 0.35.
    # The softness left: 0.245 / 0.251 * 1e-4 * timestep * 1 s = 5e-7 rad at 5 ms.
    spec = spec_of(load("pendulum"), timestep=timestep)
    spec.joint("hinge").frictionloss = 0.35
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[0] = 0.05
    mujoco.mj_step(model, data, round(1.0 / timestep))
    assert abs(data.qpos[0] - 0.05) < 1e-6


@pytest.mark.parametrize("timestep", [0.0005, 0.002, 0.005])
def test_friction_below_gravity_only_takes_energy(timestep: float) -> None:
    spec = spec_of(load("double_pendulum"), timestep=timestep)
    for joint in spec.joints:
        joint.frictionloss = 0.09
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = (2.0, -1.0)
    mujoco.mj_forward(model, data)
    start = data.energy.sum()
    mujoco.mj_step(model, data, round(20.0 / timestep))
    assert data.energy.sum() < start
    # A joint comes to rest where gravity's torque is below its friction.
    assert np.abs(data.qvel).max() < 1e-5
    assert (np.abs(data.qfrc_bias) < 0.0901).all()


def test_a_small_swing_of_the_pendulum_takes_the_time_of_a_physical_pendulum() -> None:
    # T = 2 pi sqrt(I / (m g d)) = 2 pi sqrt(0.251 / 4.905) = 1.42133 s; an
    # amplitude of 0.01 rad lengthens it by 0.01^2 / 16 = 6e-6 of itself.
    period = 2 * math.pi * math.sqrt(0.251 / (1.0 * 9.81 * 0.5))
    model = spec_of(load("pendulum"), timestep=0.0001).compile()
    data = mujoco.MjData(model)
    data.qpos[0] = 0.01
    crossings: list[float] = []
    while len(crossings) < 3:
        before, time = data.qpos[0], data.time
        mujoco.mj_step(model, data)
        if before * data.qpos[0] < 0:
            crossings.append(time + 0.0001 * before / (before - data.qpos[0]))
    assert crossings[2] - crossings[0] == pytest.approx(period, rel=2e-5)


@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi])
def test_the_mass_matrix_of_the_cart_pole_is_the_thesis(angle: float) -> None:
    # (M + m) x'' + m l / 2 cos(a) a'' = ..., and m l / 2 cos(a) x'' + m l^2 / 3 a'' = ...
    coupling = 0.5 * 0.5 / 2 * math.cos(angle)
    wanted = [[1.0, coupling], [coupling, 0.5 * 0.5**2 / 3]]
    model = spec_of(load("cartpole")).compile()
    assert mass_matrix(model, np.array([0.3, angle])) == pytest.approx(np.array(wanted), abs=1e-12)


def test_the_cart_slows_at_the_thesis_damping() -> None:
    # b v = 0.1 N s/m * 2 m/s; gravity on the level pole: m g l / 2 = 1.2275 N m.
    model = spec_of(load("cartpole")).compile()
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = (0.0, math.pi / 2), (2.0, 0.0)
    mujoco.mj_forward(model, data)
    assert data.qfrc_passive == pytest.approx([-0.2, 0.0], abs=1e-12)
    assert data.qfrc_bias == pytest.approx([0.0, 0.5 * 9.82 * 0.25], abs=1e-12)


# m1, I1, I2, m2, l1, r2, armature; I about each joint, as DFKI publishes it.
C0 = (0.6416936775868083, 0.026710760905753486, 0.05387812962959988,
      0.5639360564500752, 0.2, 0.32126693265850237, 9.937281204851094e-05 * 36)  # fmt: skip
A0 = (0.5593806151425046, 0.053470810264216295, 0.02392374528789766,
      0.6043459469186889, 0.3, 0.18377686083653508, 7.659297952841183e-05 * 36)  # fmt: skip


@pytest.mark.parametrize(("name", "figures"), [("double_pendulum", C0), ("double_pendulum_a0", A0)])
def test_the_mass_matrix_of_the_double_pendulum_is_dfkis(
    name: str, figures: tuple[float, ...]
) -> None:
    # Spong 1995, eq. 2, with the armature of each motor on the diagonal.
    _, first, second, m2, l1, r2, armature = figures
    model = spec_of(load(name)).compile()
    cos = math.cos(0.6)
    m12 = second + m2 * l1 * r2 * cos
    m11 = first + second + m2 * l1**2 + 2 * m2 * l1 * r2 * cos
    wanted = np.array([[m11 + armature, m12], [m12, second + armature]])
    assert mass_matrix(model, np.array([0.4, 0.6])) == pytest.approx(wanted, abs=1e-12)


def test_the_so101_points_forward_at_zero() -> None:
    # Heights: 0.0949 + 0.0542 + 0.1126 + 0.0052 m; forward: 0.0304 + 0.028 + 0.1349
    # + 0.0611 + 0.0981 m; the tip stands 0.0079 m below the wrist's axis.
    model = spec_of(load("so101")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.site("tip").xpos == pytest.approx([0.3525, 0.0, 0.2590], abs=5e-4)


def test_the_so101_holds_its_pose_under_gravity() -> None:
    # A servo sags by torque / kp; the torque at Pitch is at most the arm's
    # 0.385 kg * 9.81 m/s^2 * 0.33 m = 1.25 N m, hence at most 0.07 rad.
    model = spec_of(load("so101")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 2000)
    assert np.abs(data.qvel).max() < 1e-6
    assert np.abs(data.qpos).max() < 0.07
