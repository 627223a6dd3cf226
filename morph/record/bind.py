"""An episode of a `recording.toml`, read into a recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.files import sha256
from morph.record.binding import Binding, EpisodeFiles
from morph.record.clean import clean
from morph.record.column import Column
from morph.record.read.any import read
from morph.record.read.file import hash_of
from morph.record.read.rosbag import is_bag
from morph.record.read.table import Table
from morph.record.recording import Channel, Note, Recording
from morph.record.tracked import in_canonical_frames

MOST_SHORT = 2
"""By how many samples a command may be shorter than its clock: none is sent at the end."""


def bind(episode: EpisodeFiles, binding: Binding) -> Recording:
    """Return an episode's recording.

    Raises:
        RecordingError: A file, a column or a sample of it cannot be used.
    """
    commands = {
        name: column for name, column in binding.columns.items() if _is_command(name, column)
    }
    measured = {
        name: column
        for name, column in binding.columns.items()
        if name != "time" and not (episode.command and name in commands)
    }
    tables = read(episode.file, episode.key, _wanted(measured, episode.file, binding))
    channels, notes = _channels(tables, measured, binding)
    files = [episode.file]
    if episode.command is not None:
        if not commands:
            raise RecordingError(
                "the episode has a command file, and no <actuator>.command is bound",
                where=str(binding.path),
                fix='add a line such as "hip.command" = { column = ... } to [columns]',
            )
        clock = binding
        if episode.command_time is not None:
            columns = {**binding.columns, "time": episode.command_time}
            clock = replace(binding, columns=columns, rate_hz=None)
        tables_sent = read(episode.command, wanted=_wanted(commands, episode.command, clock))
        sent, more = _channels(tables_sent, commands, clock)
        channels, notes, files = {**channels, **sent}, notes + more, [*files, episode.command]
    recording = Recording(
        name=episode.name,
        channels=channels,
        session=episode.session,
        sources=tuple(files),
        sha256=hash_of_arrays(tables) if episode.key is not None else hash_of(files),
        notes=notes,
    )
    check_overlap(recording)
    return recording


def channels_of(
    time: Array, values: Mapping[str, Array], table: Table
) -> tuple[dict[str, Channel], tuple[Note, ...]]:
    """Return cleaned channels on one clock; commands hold until the next sample.

    Raises:
        RecordingError: The samples cannot be used.
    """
    kept, cleaned, notes = clean(time, values, table)
    return {
        name: Channel(time=kept, value=value, hold=name.endswith(".command"))
        for name, value in cleaned.items()
    }, notes


def hash_of_arrays(tables: Iterable[Table]) -> str:
    """Return the hash of one episode's arrays: its file holds others too."""
    columns = (column for table in tables for column in table.columns)
    return sha256(*(each.tobytes() for each in columns if isinstance(each, np.ndarray)))


def check_overlap(recording: Recording) -> None:
    """Refuse a recording whose channels share no time.

    Raises:
        RecordingError: One has ended before another begins.
    """
    if recording.seconds <= 0.0:
        raise RecordingError(
            "the commands and the measurements, or the topics, share no time: all channels have "
            f"begun at {recording.start:.6g} s and the first ends at {recording.end:.6g} s",
            where=", ".join(map(str, recording.sources)),
            fix="check that all belong to one episode and that their clocks agree",
        )


def _wanted(columns: Mapping[str, Column], path: Path, binding: Binding) -> frozenset[str] | None:
    """Return the names of the columns that a file is read for; None if one has only a number."""
    bound = list(columns.values())
    if "time" in binding.columns and not is_bag(path):
        bound.append(binding.columns["time"])
    names = [name for column in bound for name, _ in column.sources]
    if is_bag(path):
        # A bag's columns have no order, so that a number names none of them.
        return frozenset(map(str, names))
    texts = frozenset(name for name in names if isinstance(name, str))
    return texts if len(texts) == len(set(names)) else None


def _channels(
    tables: tuple[Table, ...], columns: Mapping[str, Column], binding: Binding
) -> tuple[dict[str, Channel], tuple[Note, ...]]:
    """Return the channels bound to one file's columns, each on the clock of its table."""
    shares: list[dict[str, Column]] = [{} for _ in tables]
    for name, column in columns.items():
        shares[_table_of(name, column, tables)][name] = column
    channels: dict[str, Channel] = {}
    notes: tuple[Note, ...] = ()
    for table, share in zip(tables, shares, strict=True):
        if share:
            result, more = _on_one_clock(table, share, binding)
            channels, notes = {**channels, **result}, notes + table.notes + more
    return {name: channels[name] for name in _in_order(channels, columns)}, notes


def _in_order(channels: Iterable[str], columns: Iterable[str]) -> list[str]:
    """Return the channels in the order in which the binding names them."""
    place = {name: at for at, name in enumerate(columns)}
    return sorted(channels, key=lambda name: place.get(name, place.get(name.rpartition(".")[0], 0)))


def _table_of(name: str, column: Column, tables: tuple[Table, ...]) -> int:
    """Return which of a file's tables holds a channel's columns."""
    if len(tables) == 1:
        return 0
    holders = {
        at
        for source, _ in column.sources
        for at, table in enumerate(tables)
        if source in table.names
    }
    if len(holders) != 1:
        raise RecordingError(
            f"{name} is bound to columns that do not share a clock",
            where=f"{column.where}, for {tables[0].path}",
            fix="bind columns of one topic, and of joints that the same messages name",
        )
    return holders.pop()


def _on_one_clock(
    table: Table, columns: Mapping[str, Column], binding: Binding
) -> tuple[dict[str, Channel], tuple[Note, ...]]:
    blocks = {name: column.values(table) for name, column in columns.items()}
    repairs = in_canonical_frames(blocks, columns, table)
    values = {
        f"{name}.{axis}" if axis else name: block[:, at]
        for name, block in blocks.items()
        for at, axis in enumerate(_axes(columns[name]))
    }
    time = _clock(table, values, binding)
    short = _fit(time, values, columns, table)
    length = min([len(time), *(len(value) for value in values.values())])
    values = {name: value[:length] for name, value in values.items()}
    channels, notes = channels_of(time[:length], values, table)
    return channels, repairs + short + notes


def _axes(column: Column) -> tuple[str, ...]:
    if column.name is None or len(column.sources) == 1:
        return ("",)
    return column.name.quantity.axes


def _is_command(name: str, column: Column) -> bool:
    return column.name is not None and column.name.quantity.name == "command"


def _clock(table: Table, values: Mapping[str, Array], binding: Binding) -> Array:
    if table.clock is not None:
        return table.clock
    if binding.rate_hz is None:
        return binding.columns["time"].values(table)[:, 0]
    length = max((len(value) for value in values.values()), default=0)
    return np.arange(length) / binding.rate_hz


def _fit(
    time: Array, values: Mapping[str, Array], columns: Mapping[str, Column], table: Table
) -> tuple[Note, ...]:
    """Return notes on commands shorter than the clock; refuse any other difference."""
    notes: list[Note] = []
    for name, value in values.items():
        short = len(time) - len(value)
        if not short:
            continue
        if not name.endswith(".command") or not 0 < short <= MOST_SHORT:
            raise RecordingError(
                f"{name} has {len(value)} samples, its clock has {len(time)}",
                where=str(table.path),
                fix="bind columns of one length, or give the commands a file of their own",
            )
        notes.append(
            Note(
                what=f"{name} ends {short} samples before its clock; the end of all is dropped",
                where=str(table.path),
                dropped=short,
            )
        )
    return tuple(notes)
