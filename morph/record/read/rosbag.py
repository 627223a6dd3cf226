"""Reading ROS 2 bags: a folder with `metadata.yaml`, or one of its `.mcap` and `.db3` files.

The containers are read here, within bounds; rosbags unpacks the messages.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path, PurePosixPath

from morph.errors import RecordingError
from morph.nearest import nearest
from morph.record.limits import most_unpacked
from morph.record.read.clocked import KINDS, is_read, tables_of
from morph.record.read.file import read_bytes, size_of
from morph.record.read.mcap import scan_mcap
from morph.record.read.sqlite import scan_sqlite
from morph.record.read.table import Table, listed
from morph.record.read.topic import Messages, Topic
from morph.record.recording import Note

METADATA = "metadata.yaml"
"""The file that makes a folder a bag."""
ENDINGS = (".mcap", ".db3")
"""The endings of a bag's files."""
MOST_METADATA = 4 * 1024**2
"""The greatest `metadata.yaml`, in bytes; a thousand topics take less."""


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag: its folder, or one of its files by the ending."""
    return path.name.lower().endswith(ENDINGS) or is_bag_folder(path)


def is_bag_folder(path: Path) -> bool:
    """Return whether a path is the folder of a bag."""
    return (path / METADATA).is_file()


def read_rosbag(path: Path, wanted: Collection[str] | None = None) -> tuple[Table, ...]:
    """Return the topics of a bag as tables, those columns together that share a clock.

    Args:
        path: The folder, or one file of a bag.
        wanted: The columns to read, as `morph.record.read.clocked` names them;
            other topics are not opened. None: every topic that can be read.

    Raises:
        RecordingError: A file is missing, empty, truncated or damaged, a topic or
            a column is not there, or a message that is wanted cannot be read.
    """
    files, codec = _files(path)
    messages = Messages(
        wants=lambda topic: is_read(topic) and _is_wanted(topic, wanted),
        most=most_unpacked(sum(map(size_of, files))),
        codec=codec,
    )
    for file in files:
        (scan_mcap if file.name.lower().endswith(".mcap") else scan_sqlite)(file, messages)
    if not any(messages.counts.values()):
        raise RecordingError(
            f"the bag has {len(messages.found)} topics and no message",
            where=str(path),
            fix="record the episode again, or leave it out",
        )
    tables: list[Table] = []
    for topic, result in messages.found.items():
        if result:
            tables += tables_of(topic, sorted(result, key=lambda one: one[0]), path)
    if wanted is not None:
        _check_found(wanted, tables, messages, path)
        return tuple(tables)
    return _noted(tables, messages, path)


def _is_wanted(topic: Topic, wanted: Collection[str] | None) -> bool:
    return wanted is None or any(one.partition(":")[0] == topic.name for one in wanted)


def _files(path: Path) -> tuple[list[Path], str]:
    """Return a bag's files, in the order of its `metadata.yaml`, and how messages are packed."""
    if not path.is_dir():
        return [path], ""
    metadata = path / METADATA
    data = read_bytes(metadata, MOST_METADATA)
    try:
        lines = data.decode().splitlines()
    except UnicodeDecodeError as error:
        raise _metadata(metadata, f"byte {error.start} is no UTF-8") from error
    fields = {key.strip(): value for key, _, value in (line.partition(":") for line in lines)}
    packing = [fields.get(f"compression_{one}", "") for one in ("mode", "format")]
    mode, codec = (one.strip().strip("'\"").lower() for one in packing)
    if mode == "file":
        raise RecordingError(
            "the bag's files are compressed as a whole",
            where=str(metadata),
            fix="unpack them with `zstd -d`, and name the unpacked .db3 or .mcap file",
        )
    names = _listed_files(lines)
    if not names or not all(name.lower().endswith(ENDINGS) for name in names):
        raise _metadata(metadata, f"it lists the files {listed(names) or 'none'}")
    # Old bags list their files with the folder's own name before them; nothing outside is read.
    return [path / PurePosixPath(name).name for name in names], codec if mode == "message" else ""


def _listed_files(lines: list[str]) -> list[str]:
    """Return the items under `relative_file_paths`, in the form in which recorders write it."""
    names: list[str] = []
    inside = False
    for line in lines:
        text = line.strip()
        if inside and text.startswith("- "):
            names.append(text[2:].strip().strip("'\""))
        elif text:
            inside = text == "relative_file_paths:"
    return names


def _metadata(path: Path, what: str) -> RecordingError:
    return RecordingError(
        f"{METADATA} does not list the bag's files as a recorder does: {what}",
        where=str(path),
        fix="copy the bag again, or name its .db3 or .mcap file itself",
    )


def _shown(messages: Messages) -> str:
    """Return the topics with their types and numbers of messages."""
    return listed(
        f"{topic.name} ({topic.kind or topic.encoding or 'no type'}, {count} messages)"
        for topic, count in messages.counts.items()
    )


def _check_found(
    wanted: Collection[str], tables: list[Table], messages: Messages, path: Path
) -> None:
    """Refuse a bag without a column that is wanted."""
    names = [name for table in tables for name in table.names]
    for column in sorted(set(wanted) - set(names)):
        name = column.partition(":")[0]
        topic = next((one for one in messages.found if one.name == name), None)
        if topic is None:
            raise RecordingError(
                f"no topic of the bag has a column {column!r}; its topics are {_shown(messages)}",
                where=str(path),
                fix="name a column as <topic>:<joint>.position, or the topic of an array; the "
                f"nearest topics are {nearest(name, (one.name for one in messages.found))}",
            )
        if not is_read(topic):
            raise _not_read(topic, path)
        inside = [one for one in names if one.partition(":")[0] == name]
        raise RecordingError(
            f"topic {name} has no column {column!r}; its columns are {listed(inside) or 'none'}, "
            f"from {messages.counts[topic]} messages",
            where=f"{path}, topic {name}",
            fix=f"name a column that is there; the nearest are {nearest(column, inside)}",
        )


def _not_read(topic: Topic, path: Path) -> RecordingError:
    packed = (
        f"are packed as {topic.encoding!r}, not 'cdr', of type"
        if topic.encoding != "cdr"
        else "are"
    )
    return RecordingError(
        f"the messages {packed} {topic.kind or 'without a type'}; read are {', '.join(KINDS)}",
        where=f"{path}, topic {topic.name}",
        fix="bind another topic, or write this one again as one of these types",
    )


def _noted(tables: list[Table], messages: Messages, path: Path) -> tuple[Table, ...]:
    """Return the tables, the first with a note on the topics that could not be read."""
    other = [topic for topic in messages.found if not is_read(topic)]
    if not tables:
        raise RecordingError(
            f"no topic of the bag can be read; its topics are {_shown(messages)}",
            where=str(path),
            fix=f"record topics of the types {', '.join(KINDS)}",
        )
    if not other:
        return tuple(tables)
    note = Note(
        what="topics of other types are not read: "
        + listed(f"{topic.name} ({topic.kind or topic.encoding})" for topic in other),
        where=str(path),
    )
    return (replace(tables[0], notes=(*tables[0].notes, note)), *tables[1:])
