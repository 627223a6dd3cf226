"""How a submerged body turns: it swings about its hinge, or noses round as Munk's airships did."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from scipy.special import ellipk

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.tensor.ellipsoid import ellipsoid_tensor
from morph.sim.simulator import Simulator

RHO, GRAVITY = 1000.0, 9.81


def ellipsoid(
    written: Callable[[str], Robot], sides: tuple[float, float, float], joint: str
) -> tuple[Robot, Array]:
    """Return a solid ellipsoid as dense as water, and its whole inertia, (6,)."""
    a, b, c = sides
    mass = RHO * 4.0 / 3.0 * math.pi * a * b * c
    spin = [mass / 5.0 * (p * p + q * q) for p, q in ((b, c), (a, c), (a, b))]
    robot = written(
        f'<worldbody><body name="hull">{joint}<inertial pos="0 0 0" mass="{mass!r}" '
        f'diaginertia="{" ".join(map(repr, spin))}"/></body></worldbody>'
    )
    added = RHO * np.diag(ellipsoid_tensor(a, b, c).matrix)
    return robot, np.array([mass] * 3 + spin) + added


def test_a_submerged_pendulum_swings_with_the_water_around_it(
    written: Callable[[str], Robot],
) -> None:
    sides, lever, amplitude = (0.3, 0.2, 0.1), 0.02, 0.1
    hinge = '<joint name="hinge" axis="0 1 0"/>'
    robot, whole = ellipsoid(written, sides, hinge)
    volume = ellipsoid_tensor(*sides).volume
    effects = (
        AddedMass.of("hull", RHO * ellipsoid_tensor(*sides).matrix),
        Buoyancy(body="hull", volume=volume, density=RHO, cz=lever),
    )
    # (I + K) w' = -rho V g d sin(angle): T = 4 K(sin^2(amplitude / 2)) sqrt((I + K) / rho V g d).
    slow = math.sqrt(whole[4] / (RHO * volume * GRAVITY * lever))
    due = 4.0 * slow * float(ellipk(math.sin(0.5 * amplitude) ** 2))
    simulator = Simulator(robot, effects, step=0.005)
    simulator.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    run = simulator.run(seconds=30.0, start={"hinge": amplitude})
    time, angle = run.channel("hinge.position").time, run["hinge.position"]
    up = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    passed = time[up] - angle[up] * 0.005 / (angle[up + 1] - angle[up])
    period = float(passed[-1] - passed[0]) / (len(passed) - 1)
    # The fourth order: (w h)^4 / 120 = (2.4 * 0.005)^4 / 120 = 2e-10. A chord for the zero of a
    # sine: w^2 h^3 / 16 = 4e-8 s, at either end of ten periods.
    assert period == pytest.approx(due, rel=1e-8)
    assert due == pytest.approx(2.623559, abs=5e-7)


def test_a_spheroid_that_moves_nose_first_turns_away_as_munk_found(
    written: Callable[[str], Robot],
) -> None:
    sides, ahead, nudge = (0.5, 0.1, 0.1), 1.0, 1e-7
    robot, whole = ellipsoid(written, sides, "<freejoint/>")
    along, across, turning = whole[0], whole[1], whole[5]
    # Kirchhoff about straight motion: across v' = -along U r, turning r' = (along - across) U v.
    growth = ahead * math.sqrt(along * (across - along) / (across * turning))
    assert growth == pytest.approx(2.29840, abs=5e-6)
    simulator = Simulator(
        robot, (AddedMass.of("hull", RHO * ellipsoid_tensor(*sides).matrix),), step=0.005
    )
    simulator.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    simulator.model.opt.gravity[:] = 0.0
    run = simulator.run(
        seconds=3.0,
        speed={
            "hull.linear_velocity.x": ahead,
            "hull.linear_velocity.y": -along * ahead * nudge / (across * growth),
            "hull.angular_velocity.z": nudge,
        },
    )
    turn = run.channel("hull.angular_velocity.z")
    # The fourth order: (growth h)^5 / 120 a step, 600 steps: 1e-9. What is not linear is the
    # square of the sway, (1e-7 exp(6.9))^2 = 1e-8.
    assert turn.value == pytest.approx(nudge * np.exp(growth * turn.time), rel=2e-8)


def test_a_spheroid_that_moves_broadside_swings_about_that(written: Callable[[str], Robot]) -> None:
    # The moment that turns the nose away brings the side back.
    sides = (0.5, 0.1, 0.1)
    robot, whole = ellipsoid(written, sides, "<freejoint/>")
    along, across, turning = whole[0], whole[1], whole[5]
    simulator = Simulator(
        robot, (AddedMass.of("hull", RHO * ellipsoid_tensor(*sides).matrix),), step=0.005
    )
    simulator.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    simulator.model.opt.gravity[:] = 0.0
    swing = math.sqrt(across * (across - along) / (along * turning))
    nudge = 1e-6
    run = simulator.run(
        seconds=3.0,
        speed={"hull.linear_velocity.y": 1.0, "hull.angular_velocity.z": nudge},
    )
    turn = run.channel("hull.angular_velocity.z")
    # along u' = across V r, turning r' = (along - across) V u. RK4 errs by (swing h)^5 / 120 a
    # step: (5.4 * 0.005)^5 / 120 * 600 = 7e-8 of the swing.
    assert turn.value == pytest.approx(nudge * np.cos(swing * turn.time), abs=1e-7 * nudge)
