from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from morph.errors import RecordingError
from morph.record.frames import quaternion, turn
from morph.record.load import load_recordings

BINDING = """\
rate_hz = 10.0

[[episode]]
file = "swim.npz"
key = "7"

[columns]
"hull.orientation" = { column = [0, 1, 2], unit = "rad", form = "euler-xyz" }
"hull.linear_velocity" = { column = [3, 4, 5], unit = "m/s", frame = "body" }
"hull.angular_velocity" = { column = [6, 7, 8], unit = "rad/s" }
"""


def test_roll_pitch_and_yaw_agree_with_scipy() -> None:
    angles = np.random.default_rng(1).uniform(-1.4, 1.4, (50, 3))
    theirs = Rotation.from_euler("xyz", angles).as_quat(canonical=True)
    ours = quaternion(angles, "euler-xyz")
    ours *= np.sign(ours[:, :1])
    assert np.allclose(ours, theirs[:, [3, 0, 1, 2]], atol=1e-14)
    assert np.allclose(quaternion(theirs, "quaternion-xyzw"), ours, atol=1e-14)


def test_turning_into_the_world_and_back_agrees_with_scipy() -> None:
    rng = np.random.default_rng(2)
    rotation = Rotation.random(50, rng=rng)
    orientation = rotation.as_quat()[:, [3, 0, 1, 2]]
    vector = rng.normal(size=(50, 3))
    world = turn(vector, orientation, into="world")
    assert np.allclose(world, rotation.apply(vector), atol=1e-13)
    assert np.allclose(turn(world, orientation, into="body"), vector, atol=1e-13)


def test_a_tracked_body_is_bound_from_one_array_of_an_npz(tmp_path: Path) -> None:
    samples = np.random.default_rng(3).normal(size=(30, 9))
    np.savez(tmp_path / "swim.npz", **{"6": samples[:20], "7": samples})
    (tmp_path / "recording.toml").write_text(BINDING)
    (run,) = load_recordings(tmp_path)
    assert run.name == "swim_7"
    world = Rotation.from_euler("xyz", samples[:, :3]).apply(samples[:, 3:6])
    assert np.allclose(run["hull.linear_velocity.y"], world[:, 1], atol=1e-13)
    assert np.array_equal(run["hull.angular_velocity.z"], samples[:, 8])
    assert run["hull.orientation.w"].shape == (30,)


def test_the_same_array_under_two_keys_is_one_episode_twice(tmp_path: Path) -> None:
    samples = np.random.default_rng(3).normal(size=(30, 9))
    np.savez(tmp_path / "swim.npz", **{"6": samples, "7": samples})
    again = '[[episode]]\nfile = "swim.npz"\nkey = "6"\n\n[columns]'
    (tmp_path / "recording.toml").write_text(BINDING.replace("[columns]", again))
    (run,) = load_recordings(tmp_path)
    assert (
        "'swim_6' is identical to 'swim_7' in all its values, and was left out"
        in run.notes[-1].what
    )


def test_a_velocity_in_the_body_frame_needs_an_orientation(tmp_path: Path) -> None:
    np.savez(tmp_path / "swim.npz", **{"7": np.ones((30, 9))})
    text = "\n".join(line for line in BINDING.split("\n") if "orientation" not in line)
    (tmp_path / "recording.toml").write_text(text)
    with pytest.raises(RecordingError, match="needs the body's orientation") as caught:
        load_recordings(tmp_path)
    assert caught.value.where == f"{tmp_path / 'recording.toml'}:8"
    assert "hull.orientation" in caught.value.fix


def test_a_quaternion_that_is_none_is_refused_and_a_loose_one_repaired(tmp_path: Path) -> None:
    text = BINDING.replace(
        'column = [0, 1, 2], unit = "rad", form = "euler-xyz"',
        'column = [0, 1, 2, 3], form = "quaternion-wxyz"',
    ).replace(', frame = "body"', "")
    (tmp_path / "recording.toml").write_text(text)
    samples = np.tile([1.0, 0, 0, 0, 0, 0, 0, 0, 0], (30, 1))
    samples[4, 0] = 1.05
    np.savez(tmp_path / "swim.npz", **{"7": samples})
    (run,) = load_recordings(tmp_path)
    assert run["hull.orientation.w"][4] == pytest.approx(1.0)
    assert [note.repaired for note in run.notes] == [1]
    samples[4, 0] = 3.0
    np.savez(tmp_path / "swim.npz", **{"7": samples})
    with pytest.raises(RecordingError, match="its quaternion has length 3") as caught:
        load_recordings(tmp_path)
    assert caught.value.where.endswith("sample 4")
