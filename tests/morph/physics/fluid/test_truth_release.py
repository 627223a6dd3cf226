"""A sphere let go in the fluid: how it starts, how fast it ends, and how it gets there."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.tensor.ellipsoid import ellipsoid_tensor
from morph.sim.simulator import Simulator

RADIUS, RHO, GRAVITY = 0.1, 1000.0, 9.81
VOLUME = 4.0 / 3.0 * math.pi * RADIUS**3
STEP = 0.005


def sphere(written: Callable[[str], Robot], density: float) -> Robot:
    """Return a solid sphere of a density, kg/m3."""
    mass = density * VOLUME
    spin = 0.4 * mass * RADIUS**2
    return written(
        '<worldbody><body name="ball"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{spin!r} {spin!r} {spin!r}"/>'
        "</body></worldbody>"
    )


def water() -> tuple[Effect, ...]:
    """Return what a perfect fluid does to the sphere."""
    tensor = RHO * ellipsoid_tensor(RADIUS, RADIUS, RADIUS).matrix
    return AddedMass.of("ball", tensor), Buoyancy(body="ball", volume=VOLUME, density=RHO)


def fall(
    robot: Robot, effects: tuple[Effect, ...], seconds: float, axis: str = "z"
) -> tuple[Array, Array]:
    """Return times and speeds of a sphere let go, under Runge and Kutta's fourth order."""
    simulator = Simulator(robot, effects, step=STEP)
    simulator.model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    channel = simulator.run(seconds=seconds).channel(f"ball.linear_velocity.{axis}")
    return channel.time, channel.value


@pytest.mark.parametrize("density", [10.0, 100.0, 900.0, 1000.0, 7800.0])
def test_a_sphere_starts_against_half_the_water_that_it_displaces(
    written: Callable[[str], Robot], density: float
) -> None:
    # Lamb 1932, section 92: the sphere carries half of the mass that it displaces.
    due = (RHO - density) * GRAVITY / (density + 0.5 * RHO)
    run = Simulator(sphere(written, density), water(), step=STEP).run(seconds=1.0)
    channel = run.channel("ball.linear_velocity.z")
    # A constant acceleration is exact at every step; 200 steps add rounding of 1e-16 of g each.
    assert channel.value == pytest.approx(due * channel.time, abs=1e-12)


def test_an_accelerometer_inside_feels_the_start(written: Callable[[str], Robot]) -> None:
    mass = 100.0 * VOLUME
    robot = written(
        '<worldbody><body name="ball"><freejoint/><site name="imu"/>'
        f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="0.1 0.1 0.1"/></body></worldbody>'
        '<sensor><accelerometer name="felt" site="imu"/></sensor>'
    )
    felt = Simulator(robot, water(), step=STEP).run(seconds=1.0)["imu.accelerometer.z"]
    # (1000 - 100) g / (100 + 500) upward, and g besides, as every accelerometer reads: 2.5 g.
    # Differences of speeds up to 15 m/s, over 5 ms: 15 * 2e-16 / 0.005.
    assert felt == pytest.approx(np.full(len(felt), 2.5 * GRAVITY), abs=1e-11)


@pytest.mark.parametrize("density", [100.0, 7800.0])
def test_a_sphere_nears_its_last_speed_as_a_hyperbolic_tangent(
    written: Callable[[str], Robot], density: float
) -> None:
    drag = 0.5 * RHO * 0.47 * math.pi * RADIUS**2
    time, speed = fall(
        sphere(written, density), (*water(), QuadraticDrag(body="ball", z=drag)), 3.0
    )
    weight = (RHO - density) * VOLUME * GRAVITY
    last = math.sqrt(abs(weight) / drag)
    settling = (density + 0.5 * RHO) * VOLUME * last / abs(weight)
    # A step errs by h^5 / 120 of the fifth derivative, which is 16 of tanh at most, and what it
    # erred fades within `settling`, 0.15 s or more: 16 / 120 * (0.005 / 0.15)^4 = 1.6e-7.
    due = math.copysign(last, weight) * np.tanh(time / settling)
    assert settling > 0.15
    assert speed == pytest.approx(due, abs=1.6e-7 * last)


@pytest.mark.parametrize("density", [100.0, 7800.0])
def test_a_sphere_that_creeps_nears_its_last_speed_exponentially(
    written: Callable[[str], Robot], density: float
) -> None:
    drag = 20.0
    time, speed = fall(sphere(written, density), (*water(), LinearDrag(body="ball", z=drag)), 2.0)
    settling = (density + 0.5 * RHO) * VOLUME / drag
    last = (RHO - density) * VOLUME * GRAVITY / drag
    # As above, with a fifth derivative of 1 and over 0.12 s: (0.005 / 0.12)^4 / 120 = 2.5e-8.
    assert settling > 0.12
    assert speed == pytest.approx(last * (1.0 - np.exp(-time / settling)), abs=2.5e-8 * abs(last))


def test_a_current_takes_a_resting_sphere_along_as_a_hyperbola(
    written: Callable[[str], Robot],
) -> None:
    # Through the water it moves at w, (m + rho V / 2) dw/dt = -d w |w|: w = U / (1 + U t / s).
    drag, stream = 10.0, 0.8
    effects = (*water(), QuadraticDrag(body="ball", x=drag), FluidCurrent(x=stream))
    time, speed = fall(sphere(written, RHO), effects, 5.0, axis="x")
    length = 1.5 * RHO * VOLUME / drag
    due = stream - stream / (1.0 + stream * time / length)
    # The fourth order: (step U / s)^4 = (0.005 * 0.8 / 0.63)^4 = 1.6e-9 of the speed.
    assert speed == pytest.approx(due, abs=1.6e-9 * stream)


def test_a_sinking_sphere_ends_with_the_current_and_its_own_last_speed(
    written: Callable[[str], Robot],
) -> None:
    drag = LinearDrag(body="ball", x=40.0, y=40.0, z=40.0)
    effects = (*water(), drag, FluidCurrent(x=0.5, y=-0.3, z=0.1))
    run = Simulator(sphere(written, 1200.0), effects, step=STEP).run(seconds=6.0)
    end = [float(run[f"ball.linear_velocity.{axis}"][-1]) for axis in "xyz"]
    # It settles within (1200 + 500) V / 40 = 0.178 s: exp(-6 / 0.178) = 2e-15.
    due = [0.5, -0.3, 0.1 - 200.0 * VOLUME * GRAVITY / 40.0]
    assert end == pytest.approx(due, abs=1e-12)
