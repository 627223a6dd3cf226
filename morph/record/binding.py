"""`recording.toml`: how the files of any logger become canonical channels."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from morph.errors import RecordingError
from morph.record.column import Column, read_column
from morph.record.entry import Entry
from morph.record.limits import MOST_BINDING
from morph.record.read.rosbag import is_bag
from morph.toml_file import load_toml

HOLDS = ("zero-order",)
"""How commands on a clock of their own continue between their samples."""


@dataclass(frozen=True, kw_only=True)
class EpisodeFiles:
    """One episode's files."""

    file: Path
    """The file with its measured channels."""
    name: str
    """How reports call it."""
    key: str | None = None
    """The array or group that holds it, in an NPZ or HDF5 file of several episodes."""
    session: str = ""
    """Same day and same setup."""
    command: Path | None = None
    """A second file, on its own clock, with every `<actuator>.command`."""
    command_time: Column | None = None
    """That file's clock; None where it stands as in the first one."""


@dataclass(frozen=True, kw_only=True)
class Binding:
    """A `recording.toml`, checked."""

    path: Path
    """The file itself."""
    root: Path
    """The folder that the episodes' file names are relative to."""
    robot: str | None = None
    """A path relative to the file, or a name on the shelf."""
    rate_hz: float | None = None
    """Sampling rate of files without a clock, Hz."""
    episodes: tuple[EpisodeFiles, ...]
    """The episodes, in the order of the file."""
    columns: Mapping[str, Column] = field(default_factory=dict)
    """Each canonical channel's column; also `time`, without a rate and outside bags."""


def load_binding(path: Path, *, root: Path | None = None) -> Binding:
    """Return a `recording.toml`, checked; the files it names are not opened.

    Args:
        path: The file.
        root: Where the recordings lie; overrides the file's own `root`.

    Raises:
        RecordingError: It is no TOML, or has a key that is unknown, missing, or
            of the wrong type.
    """
    top = _parse(path)
    top.allow("root", "robot", "rate_hz", "episode", "columns")
    folder = root or path.parent / (top.text("root") or ".")
    rate = top.number("rate_hz")
    if rate is not None and rate <= 0.0:
        raise top.error(f"rate_hz is {rate:g}", "rate_hz", "give the sampling rate in Hz, above 0")
    columns = _columns(top)
    if rate is not None and "time" in columns:
        raise top.error(
            "both rate_hz and a time column are given",
            "rate_hz",
            "keep the time column if the file has a clock, else rate_hz",
        )
    episodes = _episodes(top, folder)
    _check_clock(top, episodes, rate is not None, "time" in columns)
    return Binding(
        path=path,
        root=folder,
        robot=top.text("robot"),
        rate_hz=rate,
        episodes=episodes,
        columns=columns,
    )


def _check_clock(top: Entry, episodes: tuple[EpisodeFiles, ...], rate: bool, time: bool) -> None:
    """Refuse a binding whose files are left without a clock, or have one too many."""
    files = [one.file for one in episodes] + [one.command for one in episodes if one.command]
    clocked = [is_bag(file) for file in files]
    if not all(clocked) and not (rate or time):
        raise top.error(
            "there is no clock",
            "columns",
            'add time = { column = ..., unit = "s" } to [columns], or rate_hz = ... at the top',
        )
    if all(clocked) and (rate or time):
        raise top.error(
            "a clock is bound, and every file is a bag, whose topics have clocks of their own",
            "time" if time else "rate_hz",
            "remove it: header stamps, or else the log's time, are the clock",
        )


def _parse(path: Path) -> Entry:
    try:
        table, text = load_toml(path, MOST_BINDING)
    except OSError as error:
        raise RecordingError(
            f"the binding cannot be read: {error.strerror or error}",
            where=str(path),
            fix="name the recording.toml itself",
        ) from error
    except UnicodeDecodeError as error:
        raise RecordingError(
            f"the binding is not UTF-8 text: {error.reason} at byte {error.start}",
            where=str(path),
            fix="save it as UTF-8",
        ) from error
    except ValueError as error:
        line = re.search(r"at line (\d+)", str(error))
        raise RecordingError(
            f"the binding is not valid TOML: {error}",
            where=f"{path}:{line.group(1)}" if line else str(path),
            fix="correct this line; strings need quotes, and channel names with a dot too",
        ) from error
    return Entry(table=table, path=path, document=text)


def _columns(top: Entry) -> dict[str, Column]:
    table = top.table.get("columns")
    if not isinstance(table, dict) or not set(table) - {"time"}:
        place = "to [columns]" if isinstance(table, dict) else "[columns] with"
        raise top.error(
            "the binding binds no channel: a file that it names is read by it alone",
            "columns",
            f"add {place} a line for each channel, such as "
            '"hip.position" = { column = "q1", unit = "rad" }',
        )
    return {
        name: read_column(name, top.inner(value, "columns", key=name))
        for name, value in _flat(table).items()
    }


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the columns by their full names; TOML nests what is written without quotes."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if (
            isinstance(value, dict)
            and value
            and "column" not in value
            and all(isinstance(inner, dict) for inner in value.values())
        ):
            flat.update(_flat(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _episodes(top: Entry, root: Path) -> tuple[EpisodeFiles, ...]:
    tables = top.table.get("episode")
    if not isinstance(tables, list) or not tables:
        raise top.error(
            "the binding names no episode", "episode", 'add [[episode]] with file = "..."'
        )
    entries = [top.inner(table, "episode", at=at) for at, table in enumerate(tables)]
    episodes = tuple(_episode(entry, root) for entry in entries)
    names: dict[str, int] = {}
    for at, episode in enumerate(episodes):
        if episode.name in names:
            raise entries[at].error(
                f"episodes {names[episode.name] + 1} and {at + 1} are both called {episode.name!r}",
                "name",
                "give each episode a name of its own",
            )
        names[episode.name] = at
    return episodes


def _episode(entry: Entry, root: Path) -> EpisodeFiles:
    entry.allow("file", "name", "key", "session", "command")
    file, key = entry.text("file"), entry.text("key")
    if not file:
        raise entry.error("the episode has no file", "", 'add file = "..."')
    stem = stem_of(Path(file)) + (f"_{key}" if key is not None else "")
    command, clock = _command(entry)
    return EpisodeFiles(
        file=root / file,
        name=entry.text("name") or stem,
        key=key,
        session=entry.text("session") or "",
        command=None if command is None else root / command,
        command_time=clock,
    )


def _command(entry: Entry) -> tuple[str | None, Column | None]:
    """Return the file of an episode's commands, and its clock."""
    value: object = entry.table.get("command")
    if value is None:
        return None, None
    inner = entry.inner(value, "episode", at=entry.at, key="command")
    inner.allow("file", "hold", "time")
    file, hold = inner.text("file"), inner.text("hold") or HOLDS[0]
    if not file:
        raise inner.error("the command has no file", "command", 'add file = "..."')
    if hold not in HOLDS:
        raise inner.error(
            f"hold is {hold!r}; there is {', '.join(HOLDS)}", "hold", f'write hold = "{HOLDS[0]}"'
        )
    clock = inner.table.get("time")
    if clock is None:
        return file, None
    return file, read_column("time", inner.inner(clock, "episode", at=entry.at, key="time"))


def stem_of(path: Path) -> str:
    """Return a file's name without its endings, `.csv.gz` counting as one."""
    return Path(path.name.removesuffix(".gz")).stem
