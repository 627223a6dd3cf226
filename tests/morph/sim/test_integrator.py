"""Which integrator a simulation gets."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import pytest

from morph.body.load import load
from morph.errors import SimulationFailed
from morph.physics.effect import Effect
from morph.physics.fluid import kernel
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.world.ground import Ground
from morph.sim.simulator import Simulator

WATER: tuple[Effect, ...] = (
    AddedMass(body="hull", x=3.0, y=10.0, z=28.0, rx=0.05, ry=0.6, rz=0.2),
    Buoyancy(body="hull", volume=0.0169),
)


@pytest.mark.parametrize(
    ("effects", "expected"),
    [
        ((), "implicitfast"),
        (WATER, "rk4"),
        (tuple(effect.neutral() for effect in WATER), "implicitfast"),
        ((*WATER, Ground(height=-5.0)), "implicitfast"),
        ((*WATER, CoulombFriction(joint="left_front", c=0.1)), "implicitfast"),
    ],
    ids=[
        "dry",
        "free in water",
        "in water that does nothing",
        "above a floor",
        "with dry friction",
    ],
)
def test_only_what_moves_freely_in_a_fluid_is_stepped_by_runge_kutta(
    effects: tuple[Effect, ...], expected: str
) -> None:
    assert Simulator(load("hexapod_swimmer"), effects, step=0.001).integrator == expected


def test_a_servo_that_is_stiff_for_the_step_keeps_implicitfast() -> None:
    # Its dampers, 0.3 N m s/rad on the 5.9e-4 kg m2 of a paddle about its hip, act at 509 / s:
    # in steps of 5 ms that is 2.5, beyond what is allowed (1) and near what is stable (2.7).
    robot = load("hexapod_swimmer")
    assert Simulator(robot, WATER, step=0.005).integrator == "implicitfast"
    assert Simulator(robot, WATER, step=0.001).integrator == "rk4"


def test_what_is_asked_for_is_done() -> None:
    assert Simulator(load("pendulum"), integrator="rk4").integrator == "rk4"


def test_an_integrator_that_is_none_is_refused_with_those_that_are() -> None:
    with pytest.raises(SimulationFailed, match="no integrator 'euler'; there are implicitfast"):
        Simulator(load("pendulum"), integrator="euler")  # type: ignore[arg-type]


def test_the_numpy_fluid_is_stepped_as_the_compiled_one(monkeypatch: pytest.MonkeyPatch) -> None:
    # In water a paddle weighs more, and its servo acts more slowly: without water's share the
    # 509 / s above are 1.02 a step of 2 ms, and the choice would be another.
    blade = AddedMass(body="hull", z=0.5, ry=0.01, cx=-0.1)
    every = tuple(
        replace(blade, body=f"{side}_{row}_paddle")
        for side in ("left", "right")
        for row in ("front", "middle", "rear")
    )
    robot, held = load("hexapod_swimmer"), mujoco.get_mjcb_passive()
    compiled = Simulator(robot, (*WATER, *every), step=0.002).integrator
    monkeypatch.setattr(kernel, "_kernel", lambda: None)
    mujoco.set_mjcb_passive(None)
    try:
        assert Simulator(robot, (*WATER, *every), step=0.002).integrator == compiled == "rk4"
    finally:
        mujoco.set_mjcb_passive(held)
