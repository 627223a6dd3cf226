from __future__ import annotations

import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.load import load_recordings

Write = Callable[..., Path]


@pytest.fixture
def bag(tmp_path: Path, ros: SimpleNamespace, write_bag: Write) -> Path:
    """A lone `.db3` file of 20 messages."""
    messages = [(at * 10**6, ros.joints(at * 10**6, ["hip"], [at / 3])) for at in range(20)]
    topics = [("/joint_states", "sensor_msgs/JointState", messages)]
    return write_bag(tmp_path / "run", topics, storage="sqlite3") / "run.db3"


def change(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path)) as database:
        for statement in statements:
            database.execute(statement)
        database.commit()


def test_a_name_with_signs_of_an_address_is_only_a_name(bag: Path) -> None:
    path = bag.rename(bag.with_name("run?mode=rwc#%41 1.db3"))
    before = sorted(path.parent.iterdir())
    (run,) = load_recordings(path)
    assert np.array_equal(run["hip.position"], np.arange(20) / 3)
    assert sorted(path.parent.iterdir()) == before


def test_messages_out_of_order_are_read_by_their_time(bag: Path) -> None:
    change(bag, "UPDATE messages SET id = 100 - id")
    (run,) = load_recordings(bag)
    assert np.array_equal(run["hip.position"], np.arange(20) / 3)


@pytest.mark.parametrize(
    ("statements", "what"),
    [
        (("DROP TABLE messages",), "there is no table 'messages'"),
        (("ALTER TABLE topics RENAME COLUMN type TO kind",), "'topics' has no column type"),
        (
            (
                "ALTER TABLE messages RENAME TO others",
                "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL "
                "SELECT id + 1 FROM n) SELECT id, 1 AS topic_id, id AS timestamp, "
                "zeroblob(1000000) AS data FROM n",
            ),
            "there is no table 'messages'",
        ),
        (
            (
                "DROP TABLE messages",
                "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
                "timestamp INTEGER, data BLOB AS (zeroblob(900000000)))",
                "INSERT INTO messages(topic_id, timestamp) VALUES (1, 1)",
            ),
            "'messages' has computed columns",
        ),
        (
            ("UPDATE messages SET data = zeroblob(300000000) WHERE id = 3",),
            "string or blob too big",
        ),
        (("UPDATE messages SET data = 'words'",), "has no time or no bytes"),
        (("UPDATE messages SET timestamp = 'noon' WHERE id = 5",), "has no time or no bytes"),
        (("UPDATE topics SET name = x'ff'",), "has no name or type"),
        (("UPDATE topics SET name = CAST(x'ff' AS TEXT)",), "Could not decode"),
        (("UPDATE messages SET data = x'0001'",), "the message is damaged"),
        (("DELETE FROM messages",), "1 topics and no message"),
        (("DELETE FROM topics",), "0 topics and no message"),
        (("UPDATE topics SET serialization_format = 'cbor'",), "no topic of the bag can be read"),
    ],
)
def test_a_data_base_that_is_no_bag_is_refused(
    bag: Path, statements: tuple[str, ...], what: str
) -> None:
    change(bag, *statements)
    before = sorted(bag.parent.iterdir())
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(bag)
    assert str(bag) in caught.value.where
    assert caught.value.fix
    assert sorted(bag.parent.iterdir()) == before


@pytest.mark.parametrize("kept", [0.01, 0.3, 0.8])
def test_a_truncated_file_is_refused(bag: Path, kept: float) -> None:
    data = bag.read_bytes()
    bag.write_bytes(data[: int(kept * len(data))])
    with pytest.raises(RecordingError, match="truncated, damaged or no ROS 2 bag"):
        load_recordings(bag)


def test_a_file_whose_last_messages_stand_in_a_journal_is_refused(bag: Path) -> None:
    bag.with_name("run.db3-wal").write_bytes(b"1")
    with pytest.raises(RecordingError, match=r"run\.db3-wal beside it is not empty") as caught:
        load_recordings(bag)
    assert "wal_checkpoint" in caught.value.fix


def test_topics_that_share_the_pages_of_a_name_are_refused(tmp_path: Path) -> None:
    path, size = tmp_path / "run.db3", 4096
    change(
        path,
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
        "serialization_format TEXT)",
        "CREATE TABLE messages(topic_id INTEGER, timestamp INTEGER, data BLOB)",
    )
    sizes = []
    for row in range(6):
        # So long that of each name only some 500 letters stand in the page that lists the rows.
        change(path, f"INSERT INTO topics VALUES ({row}, '{'a' * 37_320}', '', 'cdr')")
        sizes.append(path.stat().st_size)
    content = path.read_bytes()
    rows, split = content[size : 2 * size], re.compile(rb"(?<=a{200})\0...", re.DOTALL)
    # The number of the page in which a name goes on; the first row stands at the end.
    *_, first = nexts = split.findall(rows)
    assert len(nexts) == 6
    pages = (sizes[0] // size).to_bytes(4, "big")
    shared = content[:28] + pages + content[32:size] + split.sub(lambda _: first, rows)
    path.write_bytes(shared + content[2 * size : sizes[0]])
    with pytest.raises(RecordingError, match="longer names than its bytes can hold"):
        load_recordings(path)
