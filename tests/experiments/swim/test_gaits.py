"""Gaits and their figures, against symmetry, scipy and sums by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from experiments.swim.gaits import TRIPOD, begun, row, straight, tripod
from experiments.swim.mean_thrust import of_aqua, of_theory
from experiments.swim.steer import Depth, attitude, joined
from experiments.swim.water import aqua_water
from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.fluid.thrust import shed_mass, tail_force
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def swimmer() -> Robot:
    return load("hexapod_swimmer")


def test_the_stroke_is_symmetric_about_straight_back(swimmer: Robot) -> None:
    gait = straight(swimmer)
    # 2 Hz held for 10 ms: 50 commands a stroke.
    times = np.linspace(0.0, 0.49, 50)
    told = gait.act(np.empty((50, 0)), times)
    assert told.mean(axis=0) == pytest.approx(np.zeros(6), abs=1e-12)
    assert told.max(axis=0) == pytest.approx(-told.min(axis=0), abs=1e-12)


def test_a_walk_is_slowest_where_a_leg_stands_and_the_tripods_alternate(swimmer: Robot) -> None:
    gait = tripod(swimmer, frequency=0.5, ease=0.5)
    times = np.linspace(0.0, 1.99, 200)
    for actuator in swimmer.actuators:
        angle = gait.by_clock(actuator.name, times)
        rate = np.gradient(angle, 0.01)
        slowest = math.remainder(float(angle[rate.argmin()]) + math.pi / 2.0, 2.0 * math.pi)
        # Commands are 0.01 s apart, at rates of pi / 2 rad/s and more there: half of 0.016 rad.
        assert abs(slowest) < 0.02
        assert rate.min() > 0.0
        begins = math.remainder(float(angle[0]), 2.0 * math.pi)
        wanted = math.pi / 2.0 if actuator.name in TRIPOD else -math.pi / 2.0
        assert begins == pytest.approx(wanted, abs=1e-12)


def test_rowing_reversed_is_the_same_run_backward(swimmer: Robot) -> None:
    gait, back = row(swimmer), row(swimmer, sense=-1)
    times = np.linspace(0.0, 1.0, 101)
    nothing = np.empty((101, 0))
    assert back.act(nothing, times) == pytest.approx(gait.act(nothing, -times), abs=1e-12)


def test_a_run_starts_where_its_gait_does(swimmer: Robot) -> None:
    start = begun(row(swimmer), swimmer)
    assert start["left_front"] == pytest.approx(-math.pi / 2.0)
    assert start["right_rear"] == pytest.approx(math.pi / 2.0)
    assert start["left_middle"] == 0.0


@pytest.mark.parametrize(("amplitude", "frequency"), [(0.2, 1.0), (0.5, 2.0), (1.2, 3.0)])
def test_the_mean_thrust_is_the_mean_of_the_force(amplitude: float, frequency: float) -> None:
    phase = np.linspace(0.0, 2.0 * math.pi, 4096, endpoint=False)
    angle = amplitude * np.sin(phase)
    rate = amplitude * 2.0 * math.pi * frequency * np.cos(phase)
    # A positive angle lifts the end that trails: about y, the chord turns to (cos, 0, -sin).
    chord = np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=-1)
    normal = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=-1)
    velocity = 0.168 * rate[:, None] * normal
    mean = tail_force(velocity, chord, normal, shed_mass(0.05, 1000.0)).mean(axis=0)
    # A mean over a period of a smooth function of it is exact to rounding.
    told = of_theory(amplitude, frequency, reach=0.168, span=0.05)
    assert mean[0] == pytest.approx(told, rel=1e-12)
    assert abs(mean[2]) < 1e-12


def test_the_formula_in_use_for_aqua_gives_what_a_sum_by_hand_does() -> None:
    # 0.1963 * (0.05 + 2 * 0.05) * 0.16^2 / 3 * 1000 * 0.5 * 2 = 0.1963 * 1.28 = 0.251264.
    told = of_aqua(0.5, 2.0, length=0.16, widths=(0.05, 0.05))
    assert told == pytest.approx(0.251264, rel=1e-6)


def test_the_attitude_is_that_of_scipy() -> None:
    rng = np.random.default_rng(0)
    turned = Rotation.random(50, rng=rng)
    x, y, z, w = turned.as_quat().T
    time = np.arange(50.0)
    channels = {
        f"hull.orientation.{axis}": Channel(time=time, value=value)
        for axis, value in zip("wxyz", (w, x, y, z), strict=True)
    }
    found = attitude(Recording(name="turned", channels=channels))
    told = turned.as_euler("ZYX")[:, ::-1]
    assert np.sin(found - told) == pytest.approx(np.zeros((50, 3)), abs=1e-9)


def test_too_high_points_the_nose_down_and_nose_down_leans_it_up() -> None:
    def seen(height: float, pitch: float) -> Recording:
        values = {f"hull.orientation.{axis}": 0.0 for axis in "xz"} | {
            "hull.position.z": height,
            "hull.linear_velocity.z": 0.0,
            "hull.angular_velocity.y": 0.0,
            "hull.orientation.w": math.cos(pitch / 2.0),
            "hull.orientation.y": math.sin(pitch / 2.0),
        }
        time = np.zeros(1)
        channels = {n: Channel(time=time, value=np.full(1, v)) for n, v in values.items()}
        return Recording(name="seen", channels=channels)

    depth = Depth()
    assert depth.lean(seen(0.0, 0.0)) == 0.0
    # Positive pitch is nose down, and a positive lean lifts the nose.
    assert depth.lean(seen(0.0, 0.1)) > 0.0
    assert depth.lean(seen(0.1, 0.0)) < 0.0


def test_pieces_of_a_run_join_to_the_whole(swimmer: Robot) -> None:
    simulator = Simulator(swimmer, aqua_water(swimmer), step=0.002)
    first = simulator.run(seconds=0.1, command={"left_rear": 0.3})
    whole = joined([first, first])
    time = whole.channel("hull.position.z").time
    # 51 samples, and 50 that follow the one they share; 50 commands a piece.
    assert time == pytest.approx(0.002 * np.arange(101), abs=1e-12)
    told = whole.channel("left_rear.command")
    assert told.time == pytest.approx(0.002 * np.arange(100), abs=1e-12)
