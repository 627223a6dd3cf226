"""The slopes of a control period are MuJoCo's own, chained over its steps."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.errors import SimulationFailed
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant
from morph.sim.simulator import Simulator


def chained(plant: Plant, q: Array, v: Array, u: Array) -> tuple[Array, Array]:
    """Return A and B by `mjd_transitionFD`, which knows one step: A = A2 A1, B = A2 B1 + B2."""
    model = plant.model
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, u
    n = 2 * model.nv
    A, B = np.eye(n), np.zeros((n, model.nu))
    for _ in range(plant.substeps):
        a, b = np.empty((n, n)), np.empty((n, model.nu))
        mujoco.mjd_transitionFD(model, data, 1e-6, True, a, b, None, None)
        A, B = a @ A, a @ B + b
        mujoco.mj_step(model, data)
    return A, B


@pytest.mark.parametrize("name", ["cartpole", "double_pendulum", "cart_two_links_servo"])
def test_slopes_agree_with_those_of_mujoco(name: str) -> None:
    plant = Plant(Simulator(load(name), step=0.005), 0.05)
    rng = np.random.default_rng(2)
    nv, nu = plant.model.nv, plant.model.nu
    q, v = rng.normal(size=(6, nv)), rng.normal(size=(6, nv))
    u = 0.3 * plant.high * rng.uniform(-1.0, 1.0, (6, nu))
    A, B = linearise(plant, q, v, u)
    for row in range(6):
        a, b = chained(plant, q[row], v[row], u[row])
        # Both are centred differences of 1e-6: rounding of 1e-16 / 1e-6 a step, over ten steps
        # of slopes of order 10, and a curvature of 1e-12.
        assert A[row] == pytest.approx(a, abs=2e-6)
        assert B[row] == pytest.approx(b, abs=2e-6)


def test_at_its_bound_a_command_has_its_whole_slope() -> None:
    plant = Plant(Simulator(load("cartpole"), step=0.005), 0.05)
    state = np.zeros((2, 2)), np.zeros((2, 2))
    _, B = linearise(plant, *state, np.array([[10.0], [0.0]]))
    # The motion is not quite linear in the force: a share of 1e-2 between 0 and 10 N.
    assert B[0] == pytest.approx(B[1], rel=0.05, abs=1e-4)


def test_a_period_that_is_no_multiple_of_the_step_is_refused() -> None:
    with pytest.raises(SimulationFailed, match=r"0\.052 s is no multiple of a step, 0\.005 s"):
        Plant(Simulator(load("cartpole"), step=0.005), 0.052)


def test_a_row_that_becomes_unstable_is_no_number_and_leaves_the_others_alone() -> None:
    plant = Plant(Simulator(load("cartpole"), step=0.005), 0.05)
    q, v = np.zeros((2, 2)), np.array([[0.0, 1e12], [0.0, 1.0]])
    u = np.zeros((2, 1))
    alone = plant.advance(q[1:], v[1:], u[1:])
    after = plant.advance(q, v, u)
    assert np.isnan(after[0][0]).all()
    assert after[0][1] == pytest.approx(alone[0][0], abs=1e-15)
    # And the next call has forgotten it.
    assert np.isfinite(plant.advance(q, np.ones((2, 2)), u)[0]).all()
