"""The messages of one topic as tables of columns, each on its own clock.

| messages | columns of topic `T` |
|---|---|
| `sensor_msgs/JointState` | `T:<joint>.position`, `.velocity`, `.effort` |
| `sensor_msgs/Imu` | `T:<frame>.gyro.{x,y,z}`, `T:<frame>.accelerometer.{x,y,z}` |
| `geometry_msgs/PoseStamped` | `T:<body>.position.{x,y,z}`, `T:<body>.orientation.{w,x,y,z}` |
| `std_msgs/Float64MultiArray` | `T`, whose cells hold lists |

A joint's names may come in any order and any subset: it has the clock of the messages that name
it. The clock is that of the headers' stamps; a topic without stamps has that of the log.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import RecordingError
from morph.record.limits import MOST_COLUMNS
from morph.record.read.messages import ARRAY, NAMED, POSE, plain
from morph.record.read.table import Table, listed
from morph.record.read.topic import Topic
from morph.record.recording import Note

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""

KINDS = (*NAMED, ARRAY)
"""The types of messages that are read."""


def tables_of(topic: Topic, packed: Sequence[tuple[int, bytes]], path: Path) -> tuple[Table, ...]:
    """Return the columns of one topic, those that share a clock in one table.

    Args:
        topic: The topic; its messages are of one of `KINDS`.
        packed: Log time, ns, and bytes of each message, in order of time.
        path: The bag, for errors.

    Raises:
        RecordingError: A message is damaged, or does not fit those before it.
    """
    place = f"{path}, topic {topic.name}"
    messages = _unpacked(topic, [data for _, data in packed], place)
    logged = np.array([time for time, _ in packed], dtype=np.int64)
    clock, notes = _clock(messages, logged, place)
    if plain(topic.kind) == ARRAY:
        blocks = {topic.name: (np.arange(len(messages)), _lists(messages, place))}
    else:
        if plain(topic.kind) == POSE:
            _check_frame(messages, place)
        blocks, silent = _blocks(topic, messages, place)
        notes += silent
    groups: dict[bytes, list[str]] = {}
    for name, (rows, _) in blocks.items():
        groups.setdefault(rows.tobytes(), []).append(name)
    tables: list[Table] = []
    for names in groups.values():
        rows = blocks[names[0]][0]
        tables.append(
            Table(
                path=path,
                names=tuple(names),
                columns=tuple(blocks[name][1] for name in names),
                lines=rows + 1,
                topic=topic.name,
                clock=clock[rows],
                notes=() if tables else notes,
            )
        )
    return tuple(tables)


def is_read(topic: Topic) -> bool:
    """Return whether a topic's messages can be read."""
    return topic.encoding == "cdr" and plain(topic.kind) in KINDS


def _unpacked(topic: Topic, packed: Iterable[bytes], place: str) -> list[Any]:
    # The four types are the same in every release of ROS 2.
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = plain(topic.kind).replace("/", "/msg/")
    messages = []
    for at, data in enumerate(packed):
        try:
            messages.append(store.deserialize_cdr(data, kind))
        # A damaged message may end in any error of struct, numpy or rosbags itself.
        except Exception as error:
            raise RecordingError(
                f"the message is damaged, or no {topic.kind}: {str(error)[:200]}",
                where=f"{place}, message {at + 1}",
                fix="copy the bag again, or leave the topic out of the binding",
            ) from error
    return messages


def _clock(messages: list[Any], logged: Integers, place: str) -> tuple[Array, tuple[Note, ...]]:
    """Return when each message was taken, s, shape (messages,), by stamps or else by the log."""
    if not hasattr(messages[0], "header"):
        return _seconds(logged), ()
    stamps = np.array(
        [one.header.stamp.sec * NANOSECONDS + one.header.stamp.nanosec for one in messages],
        dtype=np.int64,
    )
    missing = stamps == 0
    if len(stamps) > 2 and missing[0] and not missing[1:].any():
        # Simulated time begins at 0, and then that is a stamp like the others.
        missing[0] = stamps[1] > 2 * np.diff(stamps[1:]).max()
    if not missing.any():
        return _seconds(stamps), ()
    if missing.all():
        return _seconds(logged), ()
    note = Note(
        what=f"{missing.sum()} of {len(stamps)} messages have no time stamp; "
        "the log's time is taken for all of this topic",
        where=place,
    )
    return _seconds(logged), (note,)


def _seconds(time: Integers) -> Array:
    # Whole seconds apart: nanoseconds since 1970 do not fit a float.
    whole, rest = np.divmod(time, NANOSECONDS)
    seconds: Array = whole + rest / NANOSECONDS
    return seconds


def _blocks(
    topic: Topic, messages: list[Any], place: str
) -> tuple[dict[str, tuple[Integers, Array]], tuple[Note, ...]]:
    """Return, for each column, which messages have it and its values there."""
    read = NAMED[plain(topic.kind)]
    layouts: dict[tuple[str, ...], tuple[list[int], list[Array]]] = {}
    for at, message in enumerate(messages):
        names, values = read(message, topic.name, f"{place}, message {at + 1}")
        rows, samples = layouts.setdefault(names, ([], []))
        rows.append(at)
        samples.append(values)
    parts: dict[str, list[tuple[Integers, Array]]] = {}
    for names, (rows, samples) in layouts.items():
        index, block = np.array(rows, dtype=np.int64), np.array(samples).reshape(len(rows), -1)
        for at, name in enumerate(names):
            parts.setdefault(name, []).append((index, block[:, at]))
        _check_number(parts, place)
    columns: dict[str, tuple[Integers, Array]] = {}
    silent = []
    for name, pieces in parts.items():
        index = np.concatenate([piece for piece, _ in pieces])
        values = np.concatenate([piece for _, piece in pieces])
        order = np.argsort(index)
        if np.isnan(values).all():
            silent.append(name)
        else:
            columns[f"{topic.name}:{name}"] = (index[order], values[order])
    return columns, _silence(silent, place)


def _check_frame(messages: list[Any], place: str) -> None:
    """Refuse poses of one body that are seen from several frames."""
    first = messages[0].header.frame_id
    for at, message in enumerate(messages):
        if message.header.frame_id != first:
            raise RecordingError(
                f"the pose is in frame {message.header.frame_id!r}, the first of the topic in "
                f"{first!r}",
                where=f"{place}, message {at + 1}",
                fix="publish all poses of a body in one frame that is fixed to the world",
            )


def _check_number(columns: dict[str, Any], place: str) -> None:
    if len(columns) > MOST_COLUMNS:
        raise RecordingError(
            f"the messages name more than {MOST_COLUMNS} channels",
            where=place,
            fix="check what publishes this topic: names should not change between messages",
        )


def _silence(names: list[str], place: str) -> tuple[Note, ...]:
    """Return a note on channels that are NaN throughout: drivers so mark what is missing."""
    if not names:
        return ()
    return (Note(what=f"{listed(names)}: NaN in every message, so not measured", where=place),)


def _lists(messages: list[Any], place: str) -> Array:
    """Return the numbers in each message, shape (messages, elements)."""
    first = len(messages[0].data)
    for at, message in enumerate(messages):
        if len(message.data) != first:
            raise RecordingError(
                f"the message holds {len(message.data)} numbers, the first of the topic {first}",
                where=f"{place}, message {at + 1}",
                fix="publish as many numbers in every message, or give each meaning its own topic",
            )
    lists = np.array([message.data for message in messages], dtype=np.float64)
    return lists.reshape(len(messages), first)
