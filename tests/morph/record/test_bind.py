from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.load import load_recordings

MS = 1_000_000
JOINTS, ARRAY = "sensor_msgs/JointState", "std_msgs/Float64MultiArray"
BINDING = """\
[[episode]]
file = "run"

[columns]
"elbow.position" = { column = "/arm/joint_states:joint_2.position", unit = "rad" }
"elbow.command" = { column = "/commands", element = 1, unit = "N m" }
"""

Write = Callable[..., Path]


def bound(folder: Path, ros: SimpleNamespace, write_bag: Write, text: str = BINDING) -> Path:
    """Joints at 100 Hz with stamps, commands at 50 Hz without, and two topics that nobody binds."""
    joints = [
        (at * 10 * MS + 3, ros.joints(at * 10 * MS, ["joint_1", "joint_2"], [0.0, at / 8]))
        for at in range(40)
    ]
    sent = [(at * 20 * MS, ros.array([0.0, -at])) for at in range(20)]
    # Not bound, so that its fifth message, which has another number of elements, does not matter.
    odd = [(at * MS, ros.array([1.0] * (2 if at == 4 else 3))) for at in range(10)]
    said = [(MS, ros.text("hello"))]
    topics = [("/arm/joint_states", JOINTS, joints), ("/commands", ARRAY, sent)]
    write_bag(folder / "run", [*topics, ("/odd", ARRAY, odd), ("/log", "std_msgs/String", said)])
    path = folder / "recording.toml"
    path.write_text(text)
    return path


def test_a_binding_names_columns_by_topic_each_on_its_own_clock(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    (run,) = load_recordings(bound(tmp_path, ros, write_bag))
    assert list(run.channels) == ["elbow.position", "elbow.command"]
    assert np.array_equal(run.channel("elbow.position").time, np.arange(40) / 100)
    assert np.array_equal(run["elbow.position"], np.arange(40) / 8)
    assert np.array_equal(run.channel("elbow.command").time, np.arange(20) / 50)
    # At 0.05 s the command of 0.04 s, the third, still holds.
    assert run.channel("elbow.command").at(np.array([0.05])) == pytest.approx(-2.0)


def test_commands_may_come_from_a_second_file_with_a_column_for_its_clock(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    path = bound(tmp_path, ros, write_bag)
    (tmp_path / "sent.csv").write_text(
        "ms,u\n" + "".join(f"{20 * at},{3 * at}\n" for at in range(20))
    )
    text = BINDING.replace('file = "run"', 'file = "run"\ncommand = { file = "sent.csv" }')
    text = text.replace('"/commands", element = 1', '"u"')
    path.write_text(text)
    with pytest.raises(RecordingError, match="there is no clock"):
        load_recordings(path)
    path.write_text(text + 'time = { column = "ms", unit = "ms" }\n')
    (run,) = load_recordings(path)
    assert np.array_equal(run["elbow.command"], 3.0 * np.arange(20))
    assert len(run.channel("elbow.position").time) == 40


@pytest.mark.parametrize(
    ("old", "new", "what", "fix"),
    [
        ("joint_2.pos", "joint_3.pos", "its columns are /arm/joint_states:joint_1.", "joint_2"),
        ("/arm/joint", "/arn/joint", "no topic of the bag has a column '/arn.*40 mess", "'/arm/j"),
        ('"/commands", element = 1', '"/log"', "messages are std_msgs/msg/String", "another topic"),
        ('"/commands", element = 1', '"/odd", element = 1', "2 numbers, the first .* 3", "as many"),
        ("element = 1", "element = 2", "has no element 2: each cell holds 2", "count from 0"),
        ('"/commands", element = 1', '"/commands"', "each cell .* holds 2 numbers", "element = 0"),
        (
            '"/commands", element = 1',
            "1",
            "no topic of the bag has a column '1'",
            "<topic>:<joint>",
        ),
        (
            "[columns]",
            '[columns]\ntime = { column = "t", unit = "s" }',
            "a clock is bound",
            "stamps",
        ),
        ("[[episode]]", "rate_hz = 5.0\n[[episode]]", "a clock is bound", "remove it"),
        (
            '"elbow.command" = { column = "/commands", element = 1, unit = "N m" }',
            '"hull.linear_velocity" = { column = ["/commands", "/odd", "/arm/joint_states:joint_1.'
            'position"], unit = "m/s" }',
            "2 numbers, the first .* 3",
            "as many",
        ),
        ('file = "run"', 'file = "run"\nkey = "a"', "for a file without keys", "NPZ and HDF5"),
    ],
)
def test_a_binding_that_does_not_fit_its_bag_is_refused(
    tmp_path: Path,
    ros: SimpleNamespace,
    write_bag: Write,
    old: str,
    new: str,
    what: str,
    fix: str,
) -> None:
    assert old in BINDING
    path = bound(tmp_path, ros, write_bag, BINDING.replace(old, new, 1))
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    assert str(tmp_path) in caught.value.where
    assert fix in caught.value.fix


def test_columns_of_one_channel_must_share_a_clock(
    tmp_path: Path, ros: SimpleNamespace, write_bag: Write
) -> None:
    path = bound(tmp_path, ros, write_bag)
    sources = '["/commands", "/commands", "/arm/joint_states:joint_1.position"]'
    old = '"elbow.command" = { column = "/commands", element = 1, unit = "N m" }'
    new = f'"hull.linear_velocity" = {{ column = {sources}, unit = "m/s" }}'
    path.write_text(BINDING.replace(old, new))
    with pytest.raises(RecordingError, match="do not share a clock") as caught:
        load_recordings(path)
    assert caught.value.where.startswith(f"{path}:6")
