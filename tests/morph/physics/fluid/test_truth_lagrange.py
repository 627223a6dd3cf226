"""The fluid's inertia in MuJoCo's own terms: Lagrange, inverse dynamics, energy, derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array

Make = Callable[..., Any]
HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
BASE = (SLIDE, SLIDE, SLIDE, HINGE, HINGE, HINGE)
BRANCHES = ((HINGE,), (SLIDE,), (SLIDE, HINGE), ())


@pytest.mark.parametrize(("bodies", "seed"), [(1, 0), (4, 1), (10, 2)])
def test_bias_is_what_lagrange_makes_of_the_energy(
    grown: Make, moving: Make, dense: Make, bodies: int, seed: int
) -> None:
    spec = grown(bodies, seed, ideal=True, root=BASE, kinds=BRANCHES)
    spec.option.gravity = (0.0, 0.0, 0.0)
    model = spec.compile()
    data = moving(model, seed)
    mujoco.mj_forward(model, data)
    bias, q, v = data.qfrc_bias - data.qfrc_passive, data.qpos.copy(), data.qvel.copy()

    def inertia(place: Array) -> Array:
        data.qpos[:] = place
        mujoco.mj_forward(model, data)
        return np.asarray(dense(model, data))

    # With T = v' M(q) v / 2 and v held: d/dt dT/dv = (dM/dt) v along q' = v, less dT/dq.
    step = 1e-4
    momentum = (inertia(q + step * v) - inertia(q - step * v)) @ v / (2.0 * step)
    slope = np.empty(model.nv)
    for dof in range(model.nv):
        aside = step * np.eye(model.nv)[dof]
        slope[dof] = v @ (inertia(q + aside) - inertia(q - aside)) @ v / (4.0 * step)
    # Central differences: step^2 / 6 of the third derivative, of the size of M at 1 rad a radian
    # and up to 3 rad/s: 1e-8 / 6 * 27; rounding 1e-16 / 1e-4.
    assert bias == pytest.approx(momentum - slope, abs=1e-7 * float(np.abs(bias).max()))


@pytest.mark.parametrize(("bodies", "seed"), [(1, 0), (6, 1), (15, 2), (30, 3)])
def test_inverse_dynamics_gives_back_the_forces_that_drove_the_motion(
    grown: Make, moving: Make, bodies: int, seed: int
) -> None:
    model = grown(bodies, seed).compile()
    data = moving(model, seed)
    data.qfrc_applied[:] = np.random.default_rng(seed).normal(size=model.nv)
    mujoco.mj_forward(model, data)
    mujoco.mj_inverse(model, data)
    # Of sums that reach the size of the bias.
    size = float(np.abs(data.qfrc_bias - data.qfrc_passive).max())
    assert data.qfrc_inverse == pytest.approx(data.qfrc_applied, abs=1e-12 * size)


def test_kinetic_energy_holds_that_of_the_fluid(grown: Make, moving: Make, dense: Make) -> None:
    model = grown(10, 4, ideal=True).compile()
    data = moving(model, 4)
    mujoco.mj_forward(model, data)
    mujoco.mj_energyVel(model, data)
    energy = 0.5 * data.qvel @ dense(model, data) @ data.qvel
    assert data.energy[1] == pytest.approx(energy, rel=1e-12)
    data.energy[1] = 0.0
    model.body_user[:] = 0.0
    mujoco.mj_forward(model, data)
    mujoco.mj_energyVel(model, data)
    assert data.energy[1] < 0.9 * energy


@pytest.mark.parametrize("integrator", ["mjINT_EULER", "mjINT_IMPLICITFAST"])
def test_mujocos_derivatives_are_those_of_its_steps(
    grown: Make, moving: Make, integrator: str
) -> None:
    spec = grown(6, 5)
    spec.option.integrator, spec.option.timestep = getattr(mujoco.mjtIntegrator, integrator), 0.005
    model = spec.compile()
    data = moving(model, 5, 0.5)
    size, small = 2 * model.nv, 1e-6
    slopes = np.zeros((size, size))
    mujoco.mjd_transitionFD(model, data, small, True, slopes, None, None, None)
    start = data.qpos.copy(), data.qvel.copy()

    def stepped(change: Array) -> tuple[Array, Array]:
        copy = mujoco.MjData(model)
        copy.qpos[:], copy.qvel[:] = start
        mujoco.mj_integratePos(model, copy.qpos, change[: model.nv], 1.0)
        copy.qvel[:] += change[model.nv :]
        mujoco.mj_step(model, copy)
        return copy.qpos, copy.qvel

    for column in range(size):
        change = small * np.eye(size)[column]
        (there, fast), (back, slow) = stepped(change), stepped(-change)
        moved = np.empty(model.nv)
        mujoco.mj_differentiatePos(model, moved, 2.0 * small, back, there)
        due = np.concatenate([moved, (fast - slow) / (2.0 * small)])
        # Both are central differences with the same step; rounding 1e-16 / 1e-6, of slopes near 1.
        assert slopes[:, column] == pytest.approx(due, abs=1e-8)
