"""What sensors and clocks change, and how their regressors tell it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.physics import effect_class
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.physics.sensor.sensor_scale import SensorScale
from morph.physics.sensor.timestamp_offset import TimestampOffset
from morph.sim.simulator import Simulator

START = {"shoulder": 0.5, "elbow": -0.2}
CHANNEL = "elbow.velocity"


def test_a_scale_shows_on_its_channel_only() -> None:
    robot = load("double_pendulum")
    plain = Simulator(robot).run(seconds=0.3, start=START)
    scaled = Simulator(robot, (SensorScale(channel=CHANNEL, gain=1.07),)).run(
        seconds=0.3, start=START
    )
    for name in plain.channels:
        due = plain[name] * (1.07 if name == CHANNEL else 1.0)
        assert np.array_equal(scaled[name], due)


@pytest.mark.parametrize("late", [0.013, -0.013])
def test_a_late_stamp_shows_what_was_earlier(late: float) -> None:
    robot = load("double_pendulum")
    plain = Simulator(robot).run(seconds=0.3, start=START)
    stamped = Simulator(robot, (TimestampOffset(channel=CHANNEL, T=late),)).run(
        seconds=0.3, start=START
    )
    times = np.linspace(0.05, 0.25, 30)
    for name in plain.channels:
        earlier = times - (late if name == CHANNEL else 0.0)
        # The same samples between the same neighbours: roundoff of 1e-16 s times 30 rad/s2.
        assert stamped.channel(name).at(times) == pytest.approx(
            plain.channel(name).at(earlier), abs=1e-13
        )
        assert np.array_equal(stamped[name], plain[name])


def told(effect: Effect, time: Array, reading: Array, rate: Array) -> Array:
    """Return how an effect changes what the second of two channels reads."""
    nothing = np.zeros((len(time), 1))
    motion = Motion(
        position=nothing,
        velocity=nothing,
        acceleration=nothing,
        drive=nothing[:, None],
        drive_rate=nothing[:, None],
        stiffness=nothing[:, None],
        joints={"elbow": 0},
        actuators={},
        time=time,
        channels={"elbow.position": 0, CHANNEL: 1},
        reading=np.stack([np.cos(time), reading], axis=1),
        reading_rate=np.stack([-np.sin(time), rate], axis=1),
    )
    return np.asarray(effect.reading_regressor(motion) @ effect.coefficients)


@pytest.mark.parametrize("late", [0.03, -0.03])
def test_a_late_reading_is_told_exactly(late: float) -> None:
    time = np.linspace(0.0, 2.0, 401)
    found = told(
        TimestampOffset(channel=CHANNEL, T=late), time, np.sin(3.0 * time), 3.0 * np.cos(3.0 * time)
    )
    due = np.sin(3.0 * (time - late)) - np.sin(3.0 * time)
    # The trapezoidal rule over 30 ms in steps of 5 ms: 0.03 (0.005)^2 / 12 of 27 rad/s3. Beyond an
    # end, at constant acceleration, (0.03)^3 / 6 of 27 rad/s3 and its slope from one step, 0.005
    # (0.03)^2 / 4 of it: 1.6e-4. To first order alone it would be (0.03)^2 / 2 of 9 rad/s2: 4e-3.
    assert found[:, 0] == pytest.approx(0.0, abs=0.0)
    inside = (time - late >= 0.0) & (time - late <= 2.0)
    assert found[inside, 1] == pytest.approx(due[inside], abs=2e-6)
    assert found[:, 1] == pytest.approx(due, abs=1.6e-4)


@pytest.mark.parametrize(
    ("name", "strength", "change"),
    [
        # What a channel that reads 2 + sin(3 t) reads once its law has the strength e = 1e-6.
        ("sensor_bias", 1e-6, lambda t: 2.0 + np.sin(3.0 * t) + 1e-6),
        ("sensor_scale", 1.0 + 1e-6, lambda t: (2.0 + np.sin(3.0 * t)) * (1.0 + 1e-6)),
        ("timestamp_offset", 1e-6, lambda t: 2.0 + np.sin(3.0 * (t - 1e-6))),
    ],
)
def test_a_regressor_of_readings_tells_how_they_change(
    name: str, strength: float, change: type
) -> None:
    kind = effect_class(name)
    effect = replace(kind.at(CHANNEL), **{kind.strengths[0]: strength})  # type: ignore[type-var]
    time = np.linspace(0.0, 2.0, 41)
    reading = 2.0 + np.sin(3.0 * time)
    found = told(effect, time, reading, 3.0 * np.cos(3.0 * time))
    due = np.zeros((41, 2))
    due[:, 1] = change(time) - reading
    # To first order: (3e-6)^2 / 2 of 1 rad/s, and roundoff of 1e-16 of 3 rad/s.
    assert found == pytest.approx(due, abs=5e-12)
    assert np.abs(due).max() > 9e-7
