"""Which velocities tell something of their own, and how noisy they are."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RecordingError
from morph.model.joint_rates import JointRates, with_own_rates
from morph.record.recording import Channel, Recording

TIME = 0.01 * np.arange(1200)
ENCODER, SENSOR = 1e-3, 0.02
"""Standard deviations of their noise, rad and rad/s."""
MIMIC = """
<mujoco><worldbody><body name="a"><joint name="lead" axis="0 1 0"/><geom size="0.1"/>
 <body name="b" pos="0 0 0.2"><joint name="tied" axis="0 1 0"/><geom size="0.1"/></body></body>
</worldbody><equality><joint joint1="tied" joint2="lead" polycoef="0 1 0 0 0"/></equality></mujoco>
"""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("pendulum")


def swung() -> tuple[Array, Array]:
    """Return the angle of a joint and its rate, the exact derivative."""
    fast = 2.0 * np.pi * 1.3
    return (
        0.8 * np.sin(3.0 * TIME) + 0.2 * np.sin(fast * TIME),
        2.4 * np.cos(3.0 * TIME) + 0.2 * fast * np.cos(fast * TIME),
    )


def lively() -> tuple[Array, Array]:
    """Return an angle and its rate under a torque that jumps ten times a second."""
    rng, fine = np.random.default_rng(8), 50
    push = np.repeat(rng.uniform(-40.0, 40.0, 120), 10 * fine)
    step, angle, rate, path = 0.01 / fine, 0.0, 0.0, []
    for at, now in enumerate(push):
        if at % fine == 0:
            path.append((angle, rate))
        # The exact step under a constant acceleration; a spring and damper hold it near zero.
        pull = now - 30.0 * angle - 2.0 * rate
        angle, rate = angle + step * rate + 0.5 * step**2 * pull, rate + step * pull
    return tuple(np.array(path).T)


def read(velocity: Array, position: Array) -> Recording:
    """Return a recording of the hinge of the pendulum."""
    channels = {
        "hinge.position": Channel(time=TIME, value=position),
        "hinge.velocity": Channel(time=TIME, value=velocity),
    }
    return Recording(name="run", channels=channels)


def noisy(seed: int) -> tuple[Array, Array]:
    """Return what an encoder and a sensor of velocity read."""
    rng, (angle, rate) = np.random.default_rng(seed), swung()
    return (
        angle + ENCODER * rng.standard_normal(len(TIME)),
        rate + SENSOR * rng.standard_normal(len(TIME)),
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_sensor_of_its_own_is_read_with_its_noise(robot: Robot, seed: int) -> None:
    position, velocity = noisy(seed)
    kept = with_own_rates(read(velocity, position), robot)
    assert not kept.notes
    rates = JointRates.of(kept, robot, 2.0, 8.0)
    # The third differences of 1,200 readings tell a standard deviation to 5 % or so.
    assert rates.noise == pytest.approx([SENSOR], rel=0.15)
    assert rates.dofs.tolist() == [0]
    assert rates.time == pytest.approx(TIME[200:801] - 2.0)
    assert rates.reading[:, 0] == pytest.approx(velocity[200:801])
    assert rates.valid.all()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("smoothing", [0.0, 0.8])
def test_differences_of_positions_are_not_read(robot: Robot, seed: int, smoothing: float) -> None:
    position, _ = noisy(seed)
    backward = np.diff(position, prepend=position[0]) / 0.01
    velocity = lfilter([1.0 - smoothing], [1.0, -smoothing], backward)
    kept = with_own_rates(read(velocity, position), robot)
    assert "hinge.velocity" not in kept.channels
    assert "the velocity of hinge" in kept.notes[0].what
    assert "it is not read" in kept.notes[0].what
    assert JointRates.of(kept, robot, 0.0, 12.0).reading.shape == (0, 0)


def test_motion_above_the_band_is_not_taken_for_noise(robot: Robot) -> None:
    rng, (angle, rate) = np.random.default_rng(3), lively()
    position = angle + 3e-5 * rng.standard_normal(len(TIME))
    own = rate + SENSOR * rng.standard_normal(len(TIME))
    assert "hinge.velocity" in with_own_rates(read(own, position), robot).channels
    backward = np.diff(position, prepend=position[0]) / 0.01
    smoothed = lfilter([0.5], [1.0, -0.5], backward)
    for computed in (np.gradient(position, TIME), backward, smoothed):
        kept = with_own_rates(read(computed, position), robot)
        assert "hinge.velocity" not in kept.channels


def test_of_an_encoder_that_counts_too(robot: Robot) -> None:
    counts = np.round(swung()[0] / 0.01) * 0.01
    kept = with_own_rates(read(np.gradient(counts, TIME), counts), robot)
    assert "hinge.velocity" not in kept.channels


@pytest.mark.parametrize(
    ("scale", "late"), [pytest.param(1.1, 0, id="scale"), pytest.param(1.0, 4, id="lag")]
)
def test_a_sensor_that_errs_is_not_read(robot: Robot, scale: float, late: int) -> None:
    position, velocity = noisy(0)
    _, rate = swung()
    wrong = scale * np.roll(velocity, late)
    kept = with_own_rates(read(wrong, position), robot)
    assert "hinge.velocity" not in kept.channels
    # What it errs by, to the noise's share: below 3 Hz 5 of 20 mrad/s.
    error = float(np.std((scale * np.roll(rate, late) - rate)[50:-50]))
    told = re.search(r"by (\S+) beyond the noise", kept.notes[0].what)
    assert told
    assert float(told[1]) == pytest.approx(error, rel=0.1)


def test_parts_of_an_episode_count_from_their_start(robot: Robot) -> None:
    position, velocity = noisy(0)
    whole = JointRates.of(read(velocity, position), robot, 0.0, 12.0)
    some = whole.between(3.0, 4.0, zero=2.995)
    assert some.time == pytest.approx(0.005 + 0.01 * np.arange(100))
    assert np.array_equal(some.reading, whole.reading[300:400])


def test_what_no_joint_does_is_refused(robot: Robot) -> None:
    position, velocity = noisy(0)
    with pytest.raises(RecordingError, match=r"a velocity of 1e\+09 is none that a joint has"):
        with_own_rates(read(np.where(TIME[7] == TIME, 1e9, velocity), position), robot)


def test_joints_that_follow_keep_none(tmp_path: Path) -> None:
    path = tmp_path / "tied.xml"
    path.write_text(MIMIC)
    _, velocity = noisy(0)
    channels = {f"{name}.velocity": Channel(time=TIME, value=velocity) for name in ("lead", "tied")}
    kept = with_own_rates(Recording(name="run", channels=channels), load(path))
    assert list(kept.channels) == ["lead.velocity"]


def test_a_sensor_beside_a_guess_is_read(robot: Robot) -> None:
    position, velocity = noisy(0)
    run = read(velocity, position)
    guessed = {**run.channels, "hinge.position": replace(run.channels["hinge.position"], guess=0.1)}
    kept = with_own_rates(replace(run, channels=guessed), robot)
    assert JointRates.of(kept, robot, 0.0, 12.0).noise == pytest.approx([SENSOR], rel=0.15)


def test_a_velocity_is_not_read_where_it_turns_at_once(robot: Robot) -> None:
    time = 0.01 * np.arange(500)
    rng = np.random.default_rng(3)
    # A force jumps at 2.5 s; the swing's own second differences are 11 times the noise.
    speed = 3.0 * np.sin(6.0 * time) + 20.0 * np.maximum(time - 2.5, 0.0)
    channels = {
        "hinge.velocity": Channel(time=time, value=speed + 1e-3 * rng.standard_normal(500)),
    }
    seen = JointRates.of(Recording(name="run", channels=channels), robot, 0.0, 5.0)
    lost = np.flatnonzero(~seen.valid[:, 0])
    # Second differences have 2.4 times the noise, of which 16 times is seven.
    assert lost.tolist() == [249, 250, 251]
