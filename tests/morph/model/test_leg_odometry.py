"""Where a base is by its feet: a leg that rolls over a ball foot, in closed form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.model.leg_odometry import UNSURE, with_leg_odometry
from morph.record.recording import Channel, Recording

LENGTH, RADIUS = 0.4, 0.03
"""From the hip to the middle of the foot, and the foot's radius, m."""
TIME = 0.01 * np.arange(300)


def description(floor: str = '<geom name="floor" type="plane" size="0 0 1"/>') -> str:
    """Return a trunk on two legs with ball feet."""
    leg = f"""<body name="{{0}}_shank" pos="0 {{1}} 0"><joint name="{{0}}" axis="0 1 0"/>
     <geom type="capsule" fromto="0 0 0 0 0 -{LENGTH - 0.05}" size="0.02" mass="0.3"/>
     <geom type="sphere" pos="0 0 -{LENGTH}" size="{RADIUS}" mass="0.1"/></body>"""
    return f"""
<mujoco><worldbody>{floor}<body name="trunk"><freejoint/>
 <geom type="box" size="0.1 0.1 0.05" mass="2"/>{leg.format("left", 0.1)}{leg.format("right", -0.1)}
 </body></worldbody></mujoco>
"""


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    return loaded(tmp_path, description())


def loaded(folder: Path, text: str) -> Robot:
    path = folder / "legs.xml"
    path.write_text(text)
    return load(path)


def read(left: Array, right: Array) -> Recording:
    """Return how a trunk that stays level moves its legs, rad."""
    one, none = np.ones_like(TIME), np.zeros_like(TIME)
    channels = {"left.position": left, "right.position": right, "trunk.orientation.w": one}
    channels |= dict.fromkeys((f"trunk.orientation.{axis}" for axis in "xyz"), none)
    return Recording(
        name="run", channels={n: Channel(time=TIME, value=v) for n, v in channels.items()}
    )


def place(recording: Recording) -> Array:
    return np.stack([recording[f"trunk.position.{axis}"] for axis in "xyz"], axis=1)


def test_a_leg_that_stands_rolls_under_its_trunk(robot: Robot) -> None:
    angle = 0.3 * np.sin(4.0 * TIME)
    moved = with_leg_odometry(read(angle, np.full_like(angle, 1.2)), robot)
    # Turned by a about y the leg points to -x: the foot lies behind by L sin a, and rolls by R a.
    along = LENGTH * np.sin(angle) + RADIUS * angle
    # Between two samples the point that touches moves on the foot: R (da)^2 / 2 a sample at most.
    most = 300 * 0.5 * RADIUS * (0.3 * 4.0 * 0.01) ** 2
    assert np.allclose(place(moved)[:, 0], along - along[0], atol=most)
    assert np.allclose(place(moved)[:, 1], 0.0, atol=1e-12)
    assert np.allclose(place(moved)[:, 2], LENGTH * np.cos(angle) + RADIUS, atol=1e-12)
    assert moved.channels["trunk.position.z"].noise == UNSURE
    assert "where trunk was is told by its feet" in moved.notes[0].what


def test_steps_of_two_legs_add_up(robot: Robot) -> None:
    # Each leg in turn swings back by 0.2 rad while the other, bent away, swings forward.
    phase = (TIME / 0.5) % 2.0
    back, away = -0.1 + 0.2 * (phase % 1.0), np.full_like(TIME, 1.2)
    moved = with_leg_odometry(
        read(np.where(phase < 1.0, back, away), np.where(phase < 1.0, away, back)), robot
    )
    step = 2.0 * (LENGTH * np.sin(0.1) + RADIUS * 0.1)
    # Six half periods, each one sample of fifty short at the change of legs.
    assert place(moved)[-1, 0] == pytest.approx(6.0 * step * 49.0 / 50.0, rel=2e-3)


def test_a_floor_elsewhere_lifts_all(tmp_path: Path) -> None:
    high = '<geom name="floor" type="plane" size="0 0 1" pos="0 0 0.7"/>'
    run = read(np.zeros_like(TIME), np.full_like(TIME, 1.2))
    moved = with_leg_odometry(run, loaded(tmp_path, description(high)))
    assert np.allclose(place(moved)[:, 2], 0.7 + LENGTH + RADIUS, atol=1e-12)


def test_what_was_read_or_cannot_be_told_stays(robot: Robot, tmp_path: Path) -> None:
    run = read(np.zeros_like(TIME), np.full_like(TIME, 1.2))
    still = Channel(time=TIME, value=np.zeros_like(TIME))
    placed = replace(run, channels={**run.channels, "trunk.position.z": still})
    assert with_leg_odometry(placed, robot) is placed
    lacking = dict(run.channels)
    del lacking["left.position"]
    assert with_leg_odometry(replace(run, channels=lacking), robot).channels == lacking
    assert with_leg_odometry(run, loaded(tmp_path, description(floor=""))) is run
