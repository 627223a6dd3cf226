"""A trunk on two legs of which no camera tells where it is, by Newton's law alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.diagnose import diagnose
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
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("legs") / "legs.xml"
    path.write_text(LEGS)
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


def test_a_load_is_told_by_encoders_and_an_inertial_sensor(robot: Robot) -> None:
    found = diagnose(robot, [stood(number, LOAD) for number in range(4)])
    first = found.findings[0]
    assert (first.effect.name in {"payload", "link_inertia"}, first.effect.where) == (True, "trunk")
    notes = " ".join(found.notes)
    assert "how trunk was turned is told by imu" in notes
    assert "where trunk was is told by its feet on the floor" in notes


def test_legs_that_stand_as_described_is_consistent(robot: Robot) -> None:
    found = diagnose(robot, [stood(number, 0.0) for number in range(4)])
    assert (found.findings, found.verdict) == ((), "consistent")
