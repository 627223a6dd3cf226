"""A trunk on two legs of which no camera tells where it is, by Newton's law alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.observed import missing, observed
from morph.inference.prepared import completed
from morph.model.episodes import Episode, episode
from morph.record.recording import Channel, Recording

GRAVITY, TRUNK, LOAD = 9.81, 2.0, 0.8
"""m/s2; the trunk as described and what it carries, kg."""
FOOT = """<body name="{0}_foot" pos="0 {1} -0.45"><joint name="{0}" type="slide" axis="0 0 -1"/>
 <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
 <geom type="box" size="0.06 0.04 0.01" solref="0.004 1"/></body>"""
LEGS = f"""
<mujoco model="legs"><worldbody>
 <geom name="floor" type="plane" size="0 0 1" solref="0.004 1"/>
 <body name="trunk"><freejoint/><site name="imu"/>
  <inertial pos="0 0 0" mass="{TRUNK}" diaginertia="0.01 0.01 0.01"/>
  {FOOT.format("left", 0.1)}{FOOT.format("right", -0.1)}</body></worldbody>
 <actuator><motor name="push_left" joint="left"/><motor name="push_right" joint="right"/></actuator>
 <sensor><gyro site="imu"/><accelerometer site="imu"/></sensor>
</mujoco>
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("legs")


@pytest.fixture(scope="module")
def robot(folder: Path) -> Robot:
    return written(folder, TRUNK)


def written(folder: Path, mass: float) -> Robot:
    """Return the legs under a trunk of some mass, kg."""
    path = folder / f"{mass}.xml"
    path.write_text(LEGS.replace(f'mass="{TRUNK}"', f'mass="{mass}"'))
    return load(path)


def stood(number: int, load: float) -> Recording:
    """Return a run in which level feet stand and the trunk goes up and down, (m + M) (z'' + g) = F.

    Encoders read the legs, and an inertial sensor how the trunk turns, which is not at all.
    """
    rng, time = np.random.default_rng(number), np.arange(0.0, 4.0, 0.005)
    length, rising = np.zeros_like(time), np.zeros_like(time)
    for _ in range(3):
        rate, phase = 2.0 * np.pi * rng.uniform(0.3, 1.5), rng.uniform(0.0, 2.0 * np.pi)
        wide = 0.02 * np.sin(rate * time + phase)
        length, rising = length + wide, rising - rate**2 * wide
    force = 0.5 * (TRUNK + load) * (rising + GRAVITY)
    # A command is held until the next: by half a period it is late.
    late = force + 0.0025 * np.gradient(force, time)
    none = np.zeros_like(time)
    exact: dict[str, Array] = {"push_left.command": late, "push_right.command": late}
    noisy = {
        **{f"{leg}.position": (length, 1e-4) for leg in ("left", "right")},
        **{f"imu.gyro.{axis}": (none, 0.005) for axis in "xyz"},
        **{f"imu.accelerometer.{axis}": (none, 0.05) for axis in "xy"},
        "imu.accelerometer.z": (rising + GRAVITY, 0.05),
    }
    exact |= {n: v + s * rng.normal(size=len(time)) for n, (v, s) in noisy.items()}
    channels = {
        name: Channel(time=time, value=value, hold="command" in name)
        for name, value in exact.items()
    }
    return Recording(name=f"run_{number}", channels=channels)


@pytest.fixture(scope="module")
def place(robot: Robot) -> Episode:
    """Return a run with the trunk's place as its feet tell it."""
    return episode(completed(stood(0, LOAD), robot), robot, 0.005)


def test_feet_and_an_inertial_sensor_tell_where_the_trunk_is(robot: Robot, place: Episode) -> None:
    channels = place.measurement.channels
    height = place.reading[:, channels.index("trunk.position.z")]
    # A foot's sole lies 0.46 m below the trunk, and its leg is as long as it is read. The first
    # 0.2 s tell tilt to 0.05 / 9.81 / sqrt(40) rad, 0.8 mrad, by an edge that is 0.14 m aside, and
    # legs are read to 0.1 mm: three standard deviations of both.
    legs = [place.reading[:, channels.index(f"{leg}.position")] for leg in ("left", "right")]
    assert height == pytest.approx(0.46 + np.maximum(*legs), abs=7e-4)
    told = " ".join(note.what for note in place.recording.notes)
    assert "how trunk was turned is told by imu" in told
    assert "where trunk was is told by its feet on the floor" in told


def test_a_load_is_what_the_description_lacks(folder: Path, place: Episode) -> None:
    robots = [written(folder, mass) for mass in (TRUNK, TRUNK + LOAD)]
    lacking = [missing([observed(spec_of(each).compile(), each, place)]) for each in robots]
    # 0.8 kg of 2.8 weigh 7.8 N, which no leg pushes.
    assert lacking[0] > 0.2
    assert lacking[1] < 0.1 * lacking[0]
