"""A cart and a pole that no sensor reads, moved by their own equation, not by MuJoCo or morph."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RecordingError
from morph.inference.diagnose import diagnose
from morph.inference.filter import Disturbance, FilterRun, Tangent
from morph.inference.unmeasured import with_unmeasured
from morph.record.recording import Channel, Recording

CART, POLE, LEVER, INERTIA, GRAVITY = 1.1, 0.4, 0.3, 0.012, 9.81
"""Masses, kg; how far from its hinge the pole weighs, m; its inertia about its middle, kg m2."""
STEP, FINE = 0.005, 10


def description(cart: float = CART, pole: float = POLE) -> str:
    """Return the rig with some masses, kg."""
    return f"""
<mujoco model="rig"><worldbody>
 <body name="trolley"><joint name="rail" type="slide" axis="1 0 0"/>
  <inertial pos="0 0 0" mass="{cart}" diaginertia="0.01 0.01 0.01"/>
  <body name="rod"><joint name="hinge" axis="0 1 0"/>
   <inertial pos="0 0 {-LEVER}" mass="{pole}" diaginertia="0.01 {INERTIA} 0.005"/></body></body>
 </worldbody><actuator><motor name="motor" joint="rail" ctrlrange="-20 20"/></actuator></mujoco>
"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("rig") / "rig.xml"
    path.write_text(description())
    return load(path)


def slopes(state: Array, force: float) -> Array:
    """Return the rates of (x, angle, and their velocities), by Lagrange's equation.

    The rod's middle lies at x - l sin a and -l cos a.
    """
    _, angle, speed, rate = state
    across = -POLE * LEVER * np.cos(angle)
    mass = np.array([[CART + POLE, across], [across, INERTIA + POLE * LEVER**2]])
    push = [force - POLE * LEVER * np.sin(angle) * rate**2, -POLE * GRAVITY * LEVER * np.sin(angle)]
    return np.concatenate([[speed, rate], np.linalg.solve(mass, push)])


def moved(number: int, coulomb: float = 0.0, seconds: float = 6.0) -> tuple[Array, Array, Array]:
    """Return times, commands and states, shape (samples, 4), of a run from rest."""
    rng, time = np.random.default_rng(number), STEP * np.arange(round(seconds / STEP))
    force = sum(
        rng.uniform(1.0, 2.5) * np.sin(2.0 * np.pi * hertz * time + rng.uniform(0.0, 6.0))
        for hertz in rng.uniform(0.2, 1.5, 4)
    )
    state, states, h = np.zeros(4), [], STEP / FINE
    for now in force:
        states.append(state)
        for _ in range(FINE):
            # Its smoothed sign: Coulomb friction that slips from 1 mm/s.
            net = now - coulomb * np.tanh(state[2] / 1e-3)
            one = slopes(state, net)
            two = slopes(state + 0.5 * h * one, net)
            state = state + h * two
    return time, np.asarray(force), np.array(states)


def recorded(number: int, coulomb: float = 0.0, hinge: bool = False) -> Recording:
    """Return 6 s of the rail's encoder and its motor, and the hinge's encoder if it has one."""
    time, force, states = moved(number, coulomb)
    rng = np.random.default_rng(100 + number)
    channels = {
        f"{name}.position": Channel(time=time, value=column + 1e-4 * rng.normal(size=len(time)))
        for name, column in zip(("rail", "hinge"), states.T, strict=False)
        if hinge or name == "rail"
    }
    channels["motor.command"] = Channel(time=time, value=force, hold=True)
    return Recording(name=f"run_{number}", channels=channels)


def tracked(number: int, coulomb: float) -> Recording:
    """Return where a camera saw the trolley, how it saw the rod turned, and the motor."""
    time, force, states = moved(number, coulomb)
    none, half = np.zeros(len(time)), 0.5 * states[:, 1]
    seen = {
        **{f"trolley.position.{axis}": none for axis in "yz"},
        **{f"rod.orientation.{axis}": none for axis in "xz"},
        "trolley.position.x": states[:, 0],
        "rod.orientation.w": np.cos(half),
        "rod.orientation.y": np.sin(half),
    }
    rng = np.random.default_rng(200 + number)
    channels = {
        name: Channel(time=time, value=value + 2e-4 * rng.normal(size=len(time)))
        for name, value in seen.items()
    }
    channels["motor.command"] = Channel(time=time, value=force, hold=True)
    return Recording(name=f"run_{number}", channels=channels)


def begun(recording: Recording, seconds: float) -> Recording:
    """Return a recording without its first seconds."""
    channels = {
        name: replace(each, time=each.time[late], value=each.value[late])
        for name, each in recording.channels.items()
        for late in [each.time >= seconds]
    }
    return replace(recording, channels=channels)


def test_a_pole_is_guessed_by_how_its_cart_moves(robot: Robot) -> None:
    time, _, states = moved(0)
    guessed = with_unmeasured(recorded(0), robot)
    channel = guessed.channels["hinge.position"]
    error = channel.value - np.interp(channel.time, time, states[:, 1])
    # It swings by 0.6 rad; the model is right, and its missing force is not known to be none.
    assert np.ptp(states[:, 1]) > 0.5
    assert np.sqrt(np.mean(error**2)) < 0.02
    assert channel.guess is not None
    assert 0.0 < channel.guess < 0.3
    assert "the position of hinge was not read" in guessed.notes[-1].what


def test_a_sensor_of_its_velocity_tells_of_a_pole(robot: Robot, tmp_path: Path) -> None:
    other = tmp_path / "other.xml"
    other.write_text(description(cart=1.3, pole=0.5))
    time, _, states = moved(0)
    rate = states[:, 3] + 0.05 * np.random.default_rng(9).normal(size=len(time))
    run, errors = recorded(0), []
    for more in ({}, {"hinge.velocity": Channel(time=time, value=rate)}):
        with_sensor = replace(run, channels={**run.channels, **more})
        channel = with_unmeasured(with_sensor, load(other)).channels["hinge.position"]
        errors.append(channel.value - np.interp(channel.time, time, states[:, 1]))
    # A cart that is described too heavy tells of its pole wrongly.
    assert np.std(errors[1]) < 0.5 * np.std(errors[0])


def test_a_joint_that_others_follow_is_guessed_with_them(tmp_path: Path) -> None:
    # A light stub turns by half as much as the rod that it bears, whose hinge follows its own.
    stub = """<body name="stub"><joint name="hinge" axis="0 1 0"/>
   <inertial pos="0 0 0" mass="1e-4" diaginertia="1e-8 1e-8 1e-8"/><body name="rod">"""
    rod = description().replace('<body name="rod">', stub).replace("</body></body>", "</body>" * 3)
    head, tail = rod.rsplit('<joint name="hinge"', 1)
    tied = '<equality><joint joint1="fold" joint2="hinge" polycoef="0 1 0 0 0"/></equality>'
    path = tmp_path / "geared.xml"
    path.write_text(f'{head}<joint name="fold"{tail}'.replace("</mujoco>", tied + "</mujoco>"))
    time, _, states = moved(0)
    channel = with_unmeasured(recorded(0), load(path)).channels["hinge.position"]
    error = channel.value - 0.5 * np.interp(channel.time, time, states[:, 1])
    assert np.sqrt(np.mean(error**2)) < 0.01


def test_a_filter_that_diverges_is_told(robot: Robot) -> None:
    fast = recorded(0)
    rail = fast.channels["rail.position"]
    wild = {**fast.channels, "rail.position": replace(rail, value=1e100 * rail.value)}
    with pytest.raises(RecordingError, match="the position of hinge was not read, and cannot be"):
        with_unmeasured(replace(fast, channels=wild), robot)


def test_what_was_read_is_no_guess(robot: Robot) -> None:
    whole = recorded(0, hinge=True)
    assert with_unmeasured(whole, robot) is whole
    assert all(channel.guess is None for channel in whole.channels.values())


def test_a_guess_is_replaced_and_noted_once(robot: Robot, tmp_path: Path) -> None:
    other = tmp_path / "other.xml"
    other.write_text(description(cart=1.3, pole=0.5))
    first = with_unmeasured(recorded(0), load(other))
    again = with_unmeasured(first, robot)
    straight = with_unmeasured(recorded(0), robot)
    assert np.array_equal(again["hinge.position"], straight["hinge.position"])
    assert not np.array_equal(first["hinge.position"], again["hinge.position"])
    assert len(again.notes) == 1


def test_nothing_is_guessed_where_nothing_was_read(robot: Robot) -> None:
    bare = recorded(0)
    bare = replace(bare, channels={"motor.command": bare.channels["motor.command"]})
    assert with_unmeasured(bare, robot) is bare
    with pytest.raises(RecordingError, match="there is no channel"):
        diagnose(robot, [bare])


def test_friction_of_the_cart_is_found_without_the_pole(robot: Robot) -> None:
    runs = [recorded(number, 0.35) for number in range(3)]
    found = diagnose(robot, runs[:2], held_out=runs[2:])
    assert [each.effect.label for each in found.findings] == ["coulomb_friction@rail"]
    estimate = found.findings[0].parameters["c"]
    # Intervals of 90 %, and twice as wide.
    half = estimate.high90 - estimate.low90
    assert abs(estimate.value - 0.35) < half < 0.1
    assert set(found.held_out_rmse["corrected"]) == {"rail.position"}
    assert any("the position of hinge was not read" in note for note in found.notes)


def test_friction_of_the_cart_is_found_by_tracked_links_alone(robot: Robot) -> None:
    runs = [tracked(number, 0.35) for number in range(3)]
    found = diagnose(robot, runs[:2], held_out=runs[2:])
    assert [each.effect.label for each in found.findings] == ["coulomb_friction@rail"]
    estimate = found.findings[0].parameters["c"]
    # The interval of 90 %, and twice as wide.
    assert abs(estimate.value - 0.35) < estimate.high90 - estimate.low90 < 0.1
    assert set(found.held_out_rmse["corrected"]) == {"rail.position", "hinge.position"}


def test_a_run_may_begin_while_the_pole_swings(robot: Robot) -> None:
    runs = [begun(recorded(number, 0.35), 1.5) for number in range(3)]
    found = diagnose(robot, runs[:2], held_out=runs[2:])
    assert [each.effect.label for each in found.findings] == ["coulomb_friction@rail"]
    # It was first guessed from rest, 0.3 rad off: from there the cart errs by 0.02 m in a second.
    assert found.held_out_rmse["corrected"]["rail.position"] < 0.005


def test_a_clean_cart_is_consistent_without_the_pole(robot: Robot) -> None:
    runs = [recorded(number) for number in range(3)]
    found = diagnose(robot, runs[:2], held_out=runs[2:])
    assert (found.verdict, found.findings) == ("consistent", ())


def test_a_filter_goes_on_about_the_motion_that_it_has_estimated() -> None:
    # A mass that is pushed for nothing: linear, so that the motion that it goes on about is free.
    rng, step, samples = np.random.default_rng(0), 0.01, 60
    tangent = Tangent(
        step=step,
        jacobian=np.tile([[0.0, -0.3, 1.7]], (samples, 1, 1)),
        reads=np.array([[1.0, 0.0]]),
        valid=np.ones((samples, 1), dtype=bool),
    )
    disturbance = Disturbance(
        noise=np.array([0.02]),
        scale=np.array([0.5]),
        correlation_time=0.3,
        initial=np.array([0.4, 0.6]),
    )
    reading = 1.0 + 0.02 * rng.normal(size=(samples, 1, 1))
    whole = FilterRun(tangent, disturbance, 1)
    whole.filter(slice(None), reading, None)
    expected, variance = whole.moved()
    # Sixty readings of one, each to 0.02, and a step of a speed near none.
    assert expected[0] == pytest.approx(1.0, abs=0.1)
    parts, state, keep = FilterRun(tangent, disturbance, 1), np.zeros(3), np.exp(-step / 0.3)
    for begin in range(0, samples, 15):
        seen = np.empty((15, 1, 1))
        for at in range(15):
            seen[at] = reading[begin + at] - state[0]
            speed = state[1] + step * (-0.3 * state[1] + 1.7 * state[2])
            state = np.array([state[0] + step * speed, speed, keep * state[2]])
        parts.filter(slice(begin, begin + 15), seen, None)
        change, again = parts.moved()
        state = state + change
    # Rounding of sums of 60 numbers near one.
    assert state == pytest.approx(expected, abs=1e-11)
    assert again == pytest.approx(variance, rel=1e-9)
