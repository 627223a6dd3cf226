"""How a link was turned, by an inertial sensor: motions whose orientation is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.model.imu_attitude import integrated, with_imu_attitude
from morph.record.recording import Channel, Recording

UP = np.array([0.0, 0.0, 9.81])
TIME = 0.005 * np.arange(4000)
DESCRIPTION = """
<mujoco><worldbody><body name="hull"><freejoint/><geom size="0.1" mass="1"/>
 <site name="imu" quat="0.5 0.5 0.5 0.5"/></body></worldbody>
 <sensor><gyro site="imu"/><accelerometer site="imu"/></sensor></mujoco>
"""


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    path = tmp_path / "hull.xml"
    path.write_text(DESCRIPTION)
    return load(path)


def turned() -> tuple[Rotation, Array]:
    """Return orientations of a body that rolls, pitches and turns, and its rates in its axes."""
    fine = np.stack([0.4 * np.sin(1.3 * TIME), 0.3 * np.sin(2.1 * TIME), 0.5 * TIME], axis=1)
    rotation = Rotation.from_euler("XYZ", fine)
    nudge = 1e-6
    later = Rotation.from_euler(
        "XYZ",
        np.stack(
            [
                0.4 * np.sin(1.3 * (TIME + nudge)),
                0.3 * np.sin(2.1 * (TIME + nudge)),
                0.5 * (TIME + nudge),
            ],
            axis=1,
        ),
    )
    return rotation, (rotation.inv() * later).as_rotvec() / nudge


def apart(quaternions: Array, rotation: Rotation) -> Array:
    """Return angles between orientations, rad."""
    told = Rotation.from_quat(quaternions, scalar_first=True)
    return (told * rotation.inv()).magnitude()


def test_rates_and_gravity_tell_how_a_body_turns() -> None:
    rotation, rates = turned()
    told = integrated(TIME, rates, rotation.inv().apply(UP), UP)
    # The mean of the first 0.2 s takes the body for level: it turns by 0.05 and 0.06 rad in them.
    # That fades with 2 s but for the heading, which 0.5 rad/s have turned by 0.05 rad by then.
    # Meanwhile 0.08 rad / 2 s are taken for a bias for 2 of 20 s: 4 mrad/s, worth 8 mrad of tilt.
    assert apart(told, rotation)[TIME > 10.0].max() < 0.06
    tilt = rotation.inv().apply(UP / 9.81)
    shown = Rotation.from_quat(told, scalar_first=True).inv().apply(UP / 9.81)
    assert np.linalg.norm(shown - tilt, axis=1)[TIME > 10.0].max() < 8e-3


def test_a_bias_of_the_gyro_is_learned() -> None:
    rotation, rates = turned()
    biased = integrated(TIME, rates + np.array([0.02, -0.01, 0.0]), rotation.inv().apply(UP), UP)
    shown = Rotation.from_quat(biased, scalar_first=True).inv().apply(UP / 9.81)
    tilt = rotation.inv().apply(UP / 9.81)
    late = TIME > 15.0
    # Unlearned it tilts by 0.022 rad/s times the 2 s in which tilt is corrected.
    assert np.linalg.norm(shown - tilt, axis=1)[late].max() < 0.5 * 0.022 * 2.0


def test_a_sensor_that_lies_turned_on_its_link(robot: Robot) -> None:
    rotation, rates = turned()
    on_link = Rotation.from_quat([0.5, 0.5, 0.5, 0.5])
    read = {"gyro": rates, "accelerometer": rotation.inv().apply(UP)}
    channels = {
        f"imu.{name}.{axis}": Channel(time=TIME, value=value)
        for name, values in read.items()
        for axis, value in zip("xyz", on_link.inv().apply(values).T, strict=True)
    }
    told = with_imu_attitude(Recording(name="run", channels=channels), robot)
    straight = integrated(TIME, rates, rotation.inv().apply(UP), UP)
    for axis, value in zip("wxyz", straight.T, strict=True):
        assert told[f"hull.orientation.{axis}"] == pytest.approx(value, abs=1e-12)
    assert "how hull was turned is told by imu" in told.notes[0].what


def test_a_sensor_at_a_link_that_is_fixed_to_the_base(tmp_path: Path) -> None:
    path = tmp_path / "hull.xml"
    bare = DESCRIPTION[: DESCRIPTION.index("<site")] + "</body></worldbody></mujoco>"
    # A quarter of a turn about z: its x axis is the hull's y.
    fixed = '<body name="imu_link" quat="0.7071067811865476 0 0 0.7071067811865476"/></body></w'
    path.write_text(bare.replace("</body></w", fixed))
    rotation, rates = turned()
    read = {"gyro": rates, "accelerometer": rotation.inv().apply(UP)}
    channels = {
        f"imu_link.{name}.{axis}": Channel(time=TIME, value=value)
        for name, values in read.items()
        for axis, value in (("x", values[:, 1]), ("y", -values[:, 0]), ("z", values[:, 2]))
    }
    told = with_imu_attitude(Recording(name="run", channels=channels), load(path))
    straight = integrated(TIME, rates, rotation.inv().apply(UP), UP)
    for axis, value in zip("wxyz", straight.T, strict=True):
        assert told[f"hull.orientation.{axis}"] == pytest.approx(value, abs=1e-9)


def test_upside_down_is_an_orientation_too() -> None:
    down = np.tile(-UP, (100, 1))
    told = integrated(TIME[:100], np.zeros((100, 3)), down, UP)
    assert Rotation.from_quat(told[-1], scalar_first=True).apply(-UP) == pytest.approx(UP)


def test_an_accelerometer_that_reads_nothing_tells_nothing(robot: Robot) -> None:
    none = Channel(time=TIME, value=np.zeros_like(TIME))
    names = [f"imu.{what}.{axis}" for what in ("gyro", "accelerometer") for axis in "xyz"]
    dead = Recording(name="run", channels=dict.fromkeys(names, none))
    assert with_imu_attitude(dead, robot) is dead


def test_without_the_sensor_nothing_is_told(robot: Robot) -> None:
    bare = Recording(name="run", channels={"imu.gyro.x": Channel(time=TIME, value=0.0 * TIME)})
    assert with_imu_attitude(bare, robot).channels == bare.channels
