"""Swimmer, sea snake and hopper of the shelf: shapes, masses and what cannot move them."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of


def model_of(name: str, *, timestep: float = 0.002) -> Any:
    """Return a body of the shelf compiled."""
    return spec_of(load(name), timestep=timestep).compile()


def test_a_swimmer_and_a_snake_weigh_what_their_water_weighs() -> None:
    for name, length in (("swimmer_three_links", 3.0), ("sea_snake", 1.4)):
        robot, model = load(name), model_of(name)
        assert robot.card is not None
        assert robot.card.water is not None
        volume, total = 0.0, 0.0
        for body in range(1, model.nbody):
            geom = model.geom(model.body(body).name)
            assert geom.type[0] == mujoco.mjtGeom.mjGEOM_BOX
            edges = 2 * geom.size
            volume += edges.prod()
            total += edges[0]
            # A uniform box: m (b^2 + c^2) / 12 about the axis of a.
            squares = edges**2
            inertia = model.body_mass[body] * (squares.sum() - squares) / 12
            full = np.zeros(9)
            mujoco.mju_quat2Mat(full, model.body_iquat[body])
            turn = full.reshape(3, 3)
            found = np.diag(turn @ np.diag(model.body_inertia[body]) @ turn.T)
            assert found == pytest.approx(inertia, rel=1e-12)
        assert volume == pytest.approx(robot.card.water.displaced_volume_m3, rel=1e-12)
        assert robot.mass == pytest.approx(1000.0 * volume, rel=1e-12)
        assert total == pytest.approx(length, abs=1e-12)


@pytest.mark.parametrize("name", ["swimmer_three_links", "sea_snake"])
def test_what_floats_cannot_push_itself_where_there_is_no_water(name: str) -> None:
    model = model_of(name, timestep=0.0005)
    model.opt.gravity[:] = 0.0
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    for step in range(1000):
        phase = 0.02 * step - np.arange(model.nu)
        data.ctrl[:] = 0.2 * model.actuator_ctrlrange[:, 1] * np.sin(phase)
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    centre = model.body_mass @ data.xipos / model.body_mass.sum()
    rest = mujoco.MjData(model)
    mujoco.mj_forward(model, rest)
    start = model.body_mass @ rest.xipos / model.body_mass.sum()
    # Without force from outside the centre rests. Runge-Kutta errs by (rate * step)^4: no
    # link turns faster than 20 rad/s, so (20 * 0.0005)^4 = 1e-8 of a body 3 m long.
    assert np.abs(data.qpos - rest.qpos).max() > 0.05
    assert np.abs(centre - start).max() < 3e-8


def test_the_hoppers_inertias_are_those_of_its_capsules() -> None:
    robot = load("hopper")
    spec = mujoco.MjSpec.from_string(robot.mjcf)
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for geom in spec.geoms:
        geom.density = 1000.0 if geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE else 0.0
    drawn, model = spec.compile(), model_of("hopper")
    assert model.body_mass == pytest.approx(drawn.body_mass, rel=1e-12)
    assert np.sort(model.body_inertia) == pytest.approx(np.sort(drawn.body_inertia), rel=1e-12)
    assert model.body_ipos == pytest.approx(drawn.body_ipos, abs=1e-12)


def test_the_hoppers_sole_is_at_zero() -> None:
    model = model_of("hopper")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    foot = model.geom("foot").id
    assert data.geom_xpos[foot, 2] - model.geom_size[foot, 0] == pytest.approx(0.0, abs=1e-12)
