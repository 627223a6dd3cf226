"""Reading the SQLite container of ROS 2 bags: its topics, and their messages, still packed.

The tables are those that rosbag2 writes since its first version
(https://github.com/ros2/rosbag2, rosbag2_storage_sqlite3): `topics` and `messages`.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from morph.errors import RecordingError
from morph.record.limits import MOST_CHUNK
from morph.record.read.file import size_of
from morph.record.read.topic import Messages, Topic

COLUMNS = {
    "topics": {"id", "name", "type", "serialization_format"},
    "messages": {"topic_id", "timestamp", "data"},
}
"""What each table must have."""


STEP = 10_000
"""Instructions of SQLite between two looks at their number."""

FREE_STEPS, STEPS_A_BYTE = 1_000_000, 10
"""Instructions for a file of any size, and for each of its bytes. A row takes some 30 of them in
all, and ten bytes at least."""


class _Steps:
    """Counts SQLite's instructions: pages may list each other so that a table has no end."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.left = FREE_STEPS + STEPS_A_BYTE * size

    def none_left(self) -> bool:
        """Return whether SQLite is to stop; called every `STEP` instructions."""
        self.left -= STEP
        return self.left < 0


def scan_sqlite(path: Path, messages: Messages) -> None:
    """Add what is wanted of a `.db3` file to the messages of a bag.

    The file is opened as one that nobody changes, so that nothing is written beside it.

    Raises:
        RecordingError: The file is missing, empty, truncated or damaged, or is
            not a bag.
    """
    steps = _Steps(size_of(path))
    _refuse_unfinished(path)
    try:
        name = quote(str(path.absolute()))
        with closing(sqlite3.connect(f"file:{name}?mode=ro&immutable=1", uri=True)) as database:
            # Pages may refer to each other in circles: nothing is longer than the file.
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(MOST_CHUNK, steps.size))
            database.set_progress_handler(steps.none_left, STEP)
            database.execute("PRAGMA trusted_schema = OFF")
            _check_tables(database, path)
            _scan(database, path, messages)
    # A text that is not UTF-8 and an integer too great for SQLite are none of its own errors.
    except (sqlite3.Error, sqlite3.Warning, UnicodeError, OverflowError) as error:
        what = "its tables list more than its bytes can hold" if steps.left < 0 else str(error)
        raise _damaged(path, what) from error


def _damaged(path: Path, what: str) -> RecordingError:
    return RecordingError(
        f"the file is truncated, damaged or no ROS 2 bag: {what}",
        where=str(path),
        fix="copy the file again, or record the episode again",
    )


def _refuse_unfinished(path: Path) -> None:
    """Refuse a file whose last messages still stand in a journal beside it."""
    for ending in ("-wal", "-journal"):
        beside = path.with_name(path.name + ending)
        if beside.is_file() and beside.stat().st_size:
            raise RecordingError(
                f"the recorder did not close the file: {beside.name} beside it is not empty",
                where=str(path),
                fix=f"run `sqlite3 {path.name} 'PRAGMA wal_checkpoint'` on a copy of both",
            )


def _check_tables(database: sqlite3.Connection, path: Path) -> None:
    """Refuse tables that are missing, or that would compute what they should hold."""
    kinds = {name: kind for _, name, kind, *_ in database.execute("PRAGMA table_list")}
    for table, wanted in COLUMNS.items():
        if kinds.get(table) != "table":
            raise _damaged(path, f"there is no table {table!r}")
        columns = list(database.execute(f"PRAGMA table_xinfo({table})"))
        missing = wanted - {name for _, name, *_ in columns}
        if missing:
            raise _damaged(path, f"the table {table!r} has no column {', '.join(sorted(missing))}")
        if any(hidden for *_, hidden in columns):
            raise _damaged(path, f"the table {table!r} has computed columns")


def _scan(database: sqlite3.Connection, path: Path, messages: Messages) -> None:
    topics: dict[int, Topic] = {}
    wanted: list[int] = []
    room = path.stat().st_size
    for number, *texts in database.execute(
        "SELECT id, name, type, serialization_format FROM topics ORDER BY id"
    ):
        if not isinstance(number, int) or not all(isinstance(text, str) for text in texts):
            raise _damaged(path, f"the topic {number!r} has no name or type")
        room -= sum(map(len, texts))
        if room < 0:
            raise _damaged(path, "its topics have longer names than its bytes can hold")
        topics[number] = Topic(name=texts[0], kind=texts[1], encoding=texts[2])
        if messages.meet(topics[number], path):
            wanted.append(number)
    for number, count in database.execute(
        "SELECT topic_id, count(*) FROM messages GROUP BY topic_id"
    ):
        if number in topics:
            messages.counts[topics[number]] += count
    # The numbers are integers of the file's own; contents of other topics are never touched.
    chosen = ", ".join(map(str, wanted))
    for number, time, data in database.execute(
        f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({chosen})"
    ):
        if not isinstance(time, int) or not isinstance(data, bytes):
            raise _damaged(path, f"a message on {topics[number].name} has no time or no bytes")
        messages.add(topics[number], time, data, path)
