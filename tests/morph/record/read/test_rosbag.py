from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.load import load_recordings

MS = 1_000_000
JOINTS, IMU, POSE, ARRAY = (
    "sensor_msgs/JointState",
    "sensor_msgs/Imu",
    "geometry_msgs/PoseStamped",
    "std_msgs/Float64MultiArray",
)
Write = Callable[..., Path]


def states(ros: SimpleNamespace, count: int = 20, stamped: bool = True) -> list:
    return [
        (at * 10 * MS + 3, ros.joints(at * 10 * MS if stamped else None, ["hip"], [at / 7]))
        for at in range(count)
    ]


@pytest.mark.parametrize(
    ("storage", "pack"),
    [("mcap", ""), ("mcap", "storage"), ("sqlite3", ""), ("sqlite3", "message")],
)
def test_joints_go_by_their_names_in_any_order_and_any_subset(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write, storage: str, pack: str
) -> None:
    messages = []
    for at in range(30):
        one = {"hip": at + 0.25, "knee": -at / 3, "toe": at * 1e-9}
        names = list(one)[:: -1 if at % 2 else 1]
        names = [name for name in names if name != "toe" or at % 3 == 0]
        numbers = [one[name] for name in names]
        speeds = [2 * number for number in numbers] if at != 4 else []
        messages.append((at * MS, ros.joints(at * MS, names, numbers, speeds)))
    path = write_bag(
        tmp_path / "run", [("/joint_states", JOINTS, messages)], storage=storage, pack=pack
    )
    (run,) = load_recordings(path)
    assert run.notes == ()
    assert set(run.channels) == {
        f"{name}.{what}" for name in ("hip", "knee", "toe") for what in ("position", "velocity")
    }
    assert np.array_equal(run["hip.position"], np.arange(30) + 0.25)
    assert np.array_equal(run["knee.position"], -np.arange(30) / 3)
    # The toe stands in every third message, and message 4 holds no velocities.
    assert np.array_equal(run.channel("toe.position").time, np.arange(0, 30, 3) / 1e3)
    assert np.array_equal(run["toe.velocity"], 2e-9 * np.arange(0, 30, 3))
    assert np.array_equal(run.channel("hip.velocity").time, np.delete(np.arange(30), 4) / 1e3)


def test_stamps_since_1970_are_rounded_once(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    start = 1_760_000_000_123_456_789
    stamps = [start + at * 1_234_567 for at in range(12)]
    messages = [(stamp + 9 * MS, ros.joints(stamp, ["hip"], [0.5])) for stamp in stamps]
    (run,) = load_recordings(write_bag(tmp_path / "run", [("/joint_states", JOINTS, messages)]))
    # Seconds and nanoseconds apart are floats to 1e-16 s; a float near 1.8e9 has steps of 2.4e-7 s.
    exact = np.array([stamp // 10**9 + (stamp % 10**9) / 1e9 for stamp in stamps])
    assert np.array_equal(run.channel("hip.position").time, exact)


@pytest.mark.parametrize("stamped", [0, 19])
def test_where_stamps_are_missing_the_log_is_the_clock(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write, stamped: int
) -> None:
    messages = [
        (at * 10 * MS + 5 * MS, ros.joints((at + 1) * MS if at < stamped else None, ["hip"], [1.0]))
        for at in range(20)
    ]
    (run,) = load_recordings(write_bag(tmp_path / "run", [("/joint_states", JOINTS, messages)]))
    assert np.array_equal(
        run.channel("hip.position").time, np.array([at * 10 + 5 for at in range(20)]) / 1e3
    )
    assert [note.what.split(";")[0] for note in run.notes] == (
        ["1 of 20 messages have no time stamp"] if stamped else []
    )


def test_an_imu_goes_by_its_frame_and_leaves_out_what_it_does_not_measure(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    rows = np.random.default_rng(3).normal(size=(15, 6))
    topics = [
        (
            f"/imu/{name}",
            IMU,
            [
                (at * MS, ros.imu(at * MS, frame, row[:3], row[3:], known))
                for at, row in enumerate(rows)
            ],
        )
        for name, frame, known in (("a", "/torso", 0.0), ("b", "", -1.0))
    ]
    (run,) = load_recordings(write_bag(tmp_path / "run", topics))
    # A first covariance of -1 says that there is no accelerometer.
    assert set(run.channels) == {
        *(f"torso.{one}.{axis}" for one in ("gyro", "accelerometer") for axis in "xyz"),
        *(f"imu/b.gyro.{axis}" for axis in "xyz"),
    }
    for at, axis in enumerate("xyz"):
        assert np.array_equal(run[f"torso.gyro.{axis}"], rows[:, at])
        assert np.array_equal(run[f"torso.accelerometer.{axis}"], rows[:, 3 + at])
        assert np.array_equal(run[f"imu/b.gyro.{axis}"], rows[:, at])


@pytest.mark.parametrize("topic", ["/mocap/hull/pose", "/hull"])
def test_a_pose_goes_by_the_body_in_its_topic(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write, topic: str
) -> None:
    rows = np.random.default_rng(4).normal(size=(15, 7))
    messages = [
        (at * MS, ros.pose(at * MS, "world", row[:3], row[3:])) for at, row in enumerate(rows)
    ]
    (run,) = load_recordings(write_bag(tmp_path / "run", [(topic, POSE, messages)]))
    names = [f"hull.position.{axis}" for axis in "xyz"]
    names += [f"hull.orientation.{axis}" for axis in "wxyz"]
    assert list(run.channels) == names
    for at, name in enumerate(names):
        assert np.array_equal(run[name], rows[:, at])


def test_what_a_bag_holds_beside_the_channels_is_noted(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    nan = float("nan")
    messages = [(at * MS, ros.joints(at * MS, ["hip"], [1.0], [], [nan])) for at in range(12)]
    topics = [
        ("/joint_states", JOINTS, messages),
        ("/commands", ARRAY, [(at * MS, ros.array([1.0, 2.0])) for at in range(12)]),
        ("/log", "std_msgs/String", [(MS, ros.text("hello"))]),
    ]
    (run,) = load_recordings(write_bag(tmp_path / "run", topics))
    assert list(run.channels) == ["hip.position"]
    said = " | ".join(note.what for note in run.notes)
    assert "hip.effort: NaN in every message" in said
    assert "/log (std_msgs/msg/String)" in said
    assert "the arrays on /commands do not say what they hold" in said


def spoilt(ros: SimpleNamespace, how: str) -> list:
    good, joints, array = states(ros), ros.joints, ros.array
    late = [(at + 10**12, message) for at, message in states(ros, stamped=False)]
    return {
        "nothing": [],
        "silence": [("/joint_states", JOINTS, [])],
        "text": [("/log", "std_msgs/String", [(1, ros.text("a"))])],
        "array": [("/a", ARRAY, [(at, array([1.0])) for at in range(12)])],
        "twice": [("/a", JOINTS, good), ("/b", JOINTS, good)],
        "lengths": [("/a", JOINTS, [*good, (10**9, joints(10**9, ["hip"], [1.0, 2.0]))])],
        "names": [("/a", JOINTS, [*good, (10**9, joints(10**9, ["a", "a"], [1.0, 2.0]))])],
        "short": [("/a", JOINTS, good[:5])],
        "back": [("/a", JOINTS, [*good, (10**9, joints(5 * MS, ["hip"], [1.0]))])],
        "infinite": [("/a", JOINTS, [*good, (10**9, joints(10**9, ["hip"], [np.inf]))])],
        "apart": [("/a", JOINTS, good), ("/hip/command", ARRAY, [
            (at, array([1.0])) for at, _ in late
        ])],
        "frames": [("/a", POSE, [
            (at, ros.pose(at + 1, "odom" if at == 7 else "map", (0, 0, 0), (1, 0, 0, 0)))
            for at in range(12)
        ])],
        "no part": [("/a", JOINTS, [(at, joints(at + 1, [""], [1.0])) for at in range(12)])],
    }[how]  # fmt: skip


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize(
    ("how", "what", "place"),
    [
        ("nothing", "0 topics and no message", "run"),
        ("silence", "1 topics and no message", "run"),
        ("text", "no topic of the bag can be read; its topics are /log", "run"),
        ("array", "the messages on /a do not say what their numbers are", "run"),
        ("twice", "both '/a:hip.position' and '/b:hip.position' are hip.position", "run"),
        ("lengths", "1 names and 2 of position", "topic /a, message 21"),
        ("names", "names 'a' twice", "topic /a, message 21"),
        ("short", "5 samples are left of 5", "run"),
        ("back", "the clock runs backwards at 1 of 21", "topic /a, message 21"),
        ("infinite", "hip.position is infinite in 1 of 21", "topic /a, message 21"),
        ("apart", "share no time", "run"),
        ("frames", "in frame 'odom', the first of the topic in 'map'", "topic /a, message 8"),
        ("no part", "'.position' names no known quantity", "topic /a, message 1"),
    ],
)
def test_a_bag_that_cannot_be_used_is_refused_at_its_message(
    tmp_path: Path,
    ros: SimpleNamespace,
    write_bag: Write,
    storage: str,
    how: str,
    what: str,
    place: str,
) -> None:
    path = write_bag(tmp_path / "run", spoilt(ros, how), storage=storage)
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    assert str(path) in caught.value.where
    assert caught.value.where.endswith(place)
    assert caught.value.fix


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("run.mcap", "../run.mcap", ""),
        ("- run.mcap", "- other.mcap", "cannot be read"),
        ("- run.mcap", "- run.txt", "does not list the bag's files .* run.txt"),
        ("relative_file_paths", "paths", "does not list the bag's files .* none"),
        ("compression_mode: ''", "compression_mode: FILE", "compressed as a whole"),
    ],
)
def test_only_files_that_lie_in_the_folder_are_read(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write, old: str, new: str, what: str
) -> None:
    folder = write_bag(tmp_path / "run", [("/joint_states", JOINTS, states(ros))])
    metadata = folder / "metadata.yaml"
    text = metadata.read_text()
    assert old in text
    metadata.write_text(text.replace(old, new))
    if not what:
        # Old recorders list files with the folder's own name before them.
        assert len(load_recordings(folder)) == 1
        return
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(folder)
    assert str(folder) in caught.value.where


def test_a_bag_in_two_files_is_one_recording(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    both = states(ros, 40)
    folder = write_bag(tmp_path / "run", [("/joint_states", JOINTS, both[20:])])
    first = write_bag(tmp_path / "first", [("/joint_states", JOINTS, both[:20])])
    (first / "first.mcap").rename(folder / "first.mcap")
    metadata = folder / "metadata.yaml"
    # In the wrong order, which the messages' times put right.
    metadata.write_text(
        metadata.read_text().replace("  - run.mcap\n", "  - run.mcap\n  - first.mcap\n")
    )
    (run,) = load_recordings(folder)
    assert np.array_equal(run["hip.position"], np.arange(40) / 7)
