"""Postures by tracked links, which are moved by rotation matrices of this file alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RecordingError
from morph.model.tracked_links import with_tracked_links
from morph.record.recording import Channel, Recording

LOW, UPPER, FORE = 0.1, 0.3, 0.25
"""Where the shoulder is, and how far the elbow and the wrist are from the joint before, m."""
NOISE = 1e-4
TIME = 0.01 * np.arange(1200.0)
ANGLES = np.stack([0.4 + 0.8 * np.sin(2.0 * TIME), 1.1 * np.cos(3.0 * TIME), 2.0 * TIME], axis=1)
"""Two joints pitch, through the outstretched posture; the third rolls on, by four turns."""
LINK = '<inertial pos="0 0 0.1" mass="1" diaginertia="0.01 0.01 0.01"/>'


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("arm") / "arm.xml"
    path.write_text(f"""
<mujoco model="arm"><worldbody>
 <body name="arm" pos="0 0 {LOW}"><joint name="shoulder" axis="0 1 0"/>{LINK}
  <body name="fore" pos="0 0 {UPPER}"><joint name="elbow" axis="0 1 0"/>{LINK}
   <body name="hand" pos="0 0 {FORE}"><joint name="wrist" axis="0 0 1"/>{LINK}
    <body name="finger" pos="0 0 0.1"><joint name="grip" axis="0 0 1"/>{LINK}</body>
  </body></body></body></worldbody>
 <equality><joint joint1="grip" joint2="wrist" polycoef="0.2 -0.5 0 0 0"/></equality></mujoco>
""")
    return load(path)


def along(direction: Array, length: Array | float) -> Array:
    """Return how far a link reaches that is pitched by an angle, m, shape (samples, 3)."""
    return length * np.stack([np.sin(direction), 0 * direction, np.cos(direction)], axis=1)


def channels(part: str, columns: Array, seed: int) -> dict[str, Channel]:
    """Return noisy channels of a link's place or orientation, or of a joint."""
    noisy = columns + NOISE * np.random.default_rng(seed).normal(size=columns.shape)
    axes = {1: [""], 3: [".x", ".y", ".z"], 4: [".w", ".x", ".y", ".z"]}[columns.shape[1]]
    return {
        f"{part}{axis}": Channel(time=TIME, value=column)
        for axis, column in zip(axes, noisy.T, strict=True)
    }


def place() -> dict[str, Channel]:
    """Return where the hand was."""
    spot = along(ANGLES[:, 0], UPPER) + along(ANGLES[:, :2].sum(axis=1), FORE)
    return channels("hand.position", spot + np.array([0.0, 0.0, LOW]), 0)


def orientation(link: str, roll: Array) -> dict[str, Channel]:
    """Return how a link that pitches and then rolls was turned: (cos, sin) of half angles."""
    pitch, half = 0.5 * ANGLES[:, :2].sum(axis=1), 0.5 * roll
    turned = np.stack(
        [
            np.cos(pitch) * np.cos(half),
            np.sin(pitch) * np.sin(half),
            np.sin(pitch) * np.cos(half),
            np.cos(pitch) * np.sin(half),
        ],
        axis=1,
    )
    return channels(f"{link}.orientation", turned, 1)


def recording(*parts: dict[str, Channel]) -> Recording:
    return Recording(name="run", channels={k: v for part in parts for k, v in part.items()})


def found(robot: Robot, *parts: dict[str, Channel]) -> dict[str, float]:
    """Return the error of each joint that is told, RMS, rad."""
    made = with_tracked_links(recording(*parts), robot)
    names = {name: f"{name}.position" for name in ("shoulder", "elbow", "wrist")}
    return {
        name: float(np.sqrt(np.mean((made[channel] - ANGLES[:, at]) ** 2)))
        for at, (name, channel) in enumerate(names.items())
        if channel in made.channels
    }


def test_a_pose_of_the_hand_tells_three_joints(robot: Robot) -> None:
    errors = found(robot, place(), orientation("hand", ANGLES[:, 2]))
    # 1e-4 m over a forearm of 0.25 m, and twice 1e-4 of a quaternion: 4.5e-4 rad.
    assert set(errors) == {"shoulder", "elbow", "wrist"}
    assert max(errors.values()) < 6e-4


def test_a_follower_is_seen_by_its_leader(robot: Robot) -> None:
    # It turns half as fast the other way, from 0.2 rad: of what both make half the roll is left.
    finger = orientation("finger", 0.2 + 0.5 * ANGLES[:, 2])
    arm = channels("shoulder.position", ANGLES[:, :1], 2)
    errors = found(robot, arm, finger)
    assert set(errors) == {"shoulder", "elbow", "wrist"}
    # A roll of the finger is half the wrist's, and noise counts twice.
    assert errors["wrist"] < 6e-4


def test_an_elbow_up_or_down_is_not_told(robot: Robot) -> None:
    assert found(robot, place()) == {}
    # Nothing but the encoder is added: the elbow is told with the shoulder.
    shoulder = channels("shoulder.position", ANGLES[:, :1], 2)
    errors = found(robot, place(), shoulder)
    assert set(errors) == {"shoulder", "elbow"}
    assert errors["elbow"] < 8e-4


def test_two_joints_about_one_axis_are_not_told_apart(robot: Robot) -> None:
    assert set(found(robot, orientation("hand", ANGLES[:, 2]))) == {"wrist"}


def test_poses_of_another_link_are_refused(robot: Robot) -> None:
    swapped = {
        name.replace("hand", "arm"): each
        for part in (place(), orientation("hand", ANGLES[:, 2]))
        for name, each in part.items()
    }
    with pytest.raises(RecordingError, match="the best posture of the description is"):
        with_tracked_links(recording(swapped), robot)


def test_what_is_read_stays(robot: Robot) -> None:
    read = [
        channels(f"{name}.position", ANGLES[:, [at]], at)
        for at, name in enumerate(("shoulder", "elbow", "wrist"))
    ]
    whole = recording(*read, place())
    assert with_tracked_links(whole, robot) is whole
    bare = recording(read[0])
    assert with_tracked_links(bare, robot) is bare
