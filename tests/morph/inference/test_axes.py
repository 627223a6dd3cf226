"""Linearised motion of a body that moves freely, against the motion of one a little off."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.inference.axes import along_body, along_parent, axes_of, jacobian_along_parent
from morph.model.measurement import deviation
from morph.physics.dynamics import jacobians
from morph.sim.tangent import Coordinates

BODY = """
<mujoco>
  <option gravity="0 0 0" integrator="Euler" timestep="0.0001"/>
  <worldbody>
    <body><freejoint/><inertial pos="0.1 0 0.05" mass="2" diaginertia="0.02 0.05 0.04"/>
      <body pos="0.2 0 0"><joint axis="0 1 0" damping="0.1" stiffness="2"/>
        <inertial pos="0.1 0 0" mass="0.5" diaginertia="0.002 0.003 0.004"/></body></body>
  </worldbody>
</mujoco>
"""
STEPS = 2000


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    """A tumbling body with an arm on a spring."""
    return mujoco.MjModel.from_xml_string(BODY)


def motion(model: mujoco.MjModel, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities from a start that is off by a move of `qpos` and `qvel`."""
    data = mujoco.MjData(model)
    data.qpos[3:7] = np.array([0.8, 0.2, -0.5, 0.26]) / np.linalg.norm([0.8, 0.2, -0.5, 0.26])
    data.qvel[:] = [0.2, -0.1, 0.3, 2.0, -3.0, 1.5, 1.0]
    mujoco.mj_integratePos(model, data.qpos, moved[: model.nv], 1.0)
    data.qvel[:] += moved[model.nv :]
    found = []
    for _ in range(STEPS):
        found.append((data.qpos.copy(), data.qvel.copy()))
        mujoco.mj_step(model, data)
    position, velocity = zip(*found, strict=True)
    return np.array(position), np.array(velocity)


def test_errors_of_a_tumbling_body_grow_as_the_linearised_model_says(
    model: mujoco.MjModel,
) -> None:
    space, dofs = Coordinates.of(model.jnt_type.tolist()), model.nv
    position, velocity = motion(model, np.zeros(2 * dofs))
    axes = axes_of(space, position)
    none = np.zeros((STEPS, 0))
    local = jacobians(model, position, velocity, none)
    jacobian = jacobian_along_parent(space, axes, velocity, local)
    off = 1e-5 * np.random.default_rng(0).normal(size=2 * dofs)
    there, rate = motion(model, off)
    # The move of `qvel`, body's axes, as errors along the parent's.
    first = [axes[0][:1], off[None, :dofs], off[None, dofs:]]
    error = along_parent(space, (first[0],), first[1])[0]
    slope = along_parent(space, (first[0],), first[2])[0]
    h = model.opt.timestep
    for t in range(STEPS - 1):
        slope = slope + h * (
            jacobian[t, :, :dofs] @ error + jacobian[t, :, dofs : 2 * dofs] @ slope
        )
        error = error + h * slope
    due = there[-1, [0, 1, 2, 7]] - position[-1, [0, 1, 2, 7]]
    turned = deviation(there[-1, 3:7], position[-1, 3:7])
    # Steps of 1e-4 s over 0.2 s at 4 rad/s: errors of relative order 4e-4; off by up to 2e-5.
    assert error[[0, 1, 2, 6]] == pytest.approx(due, abs=2e-3 * np.abs(due).max())
    assert error[3:6] == pytest.approx(turned, abs=2e-3 * np.abs(turned).max())
    last = along_parent(space, (axes[0][-1:],), (rate - velocity)[-1:])[0]
    # Rates of the error and of the velocity differ by the turn between the two bodies' axes alone.
    assert slope[[0, 1, 2, 6]] == pytest.approx(last[[0, 1, 2, 6]], abs=5e-3 * np.abs(last).max())


def test_values_turned_to_the_parent_s_axes_and_back_are_the_same(model: mujoco.MjModel) -> None:
    rng = np.random.default_rng(2)
    space = Coordinates.of(model.jnt_type.tolist())
    position = rng.normal(size=(5, model.nq))
    position[:, 3:7] /= np.linalg.norm(position[:, 3:7], axis=1, keepdims=True)
    axes, values = axes_of(space, position), rng.normal(size=(5, model.nv))
    back = along_body(space, axes, along_parent(space, axes, values))
    assert back == pytest.approx(values, abs=1e-12)
    for t in range(5):
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, position[t, 3:7])
        assert axes[0][t] == pytest.approx(turn.reshape(3, 3), abs=1e-12)
