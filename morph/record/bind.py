"""An episode of a `recording.toml`, read into a recording."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.files import sha256, sha256_of_files
from morph.record.binding import Binding, Episode
from morph.record.clean import clean
from morph.record.column import Column
from morph.record.read.any import read
from morph.record.read.table import Table
from morph.record.recording import Channel, Note, Recording
from morph.record.tracked import in_canonical_frames

MOST_SHORT = 2
"""By how many samples a command may be shorter than its clock: none is sent at the end."""


def bind(episode: Episode, binding: Binding) -> Recording:
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
    table = read(episode.file, episode.key)
    channels, notes = _channels(table, measured, binding)
    files = [episode.file]
    if episode.command is not None:
        if not commands:
            raise RecordingError(
                "the episode has a command file, and no <actuator>.command is bound",
                where=str(binding.path),
                fix='add a line such as "hip.command" = { column = ... } to [columns]',
            )
        sent, more = _channels(read(episode.command), commands, binding)
        channels, notes, files = {**channels, **sent}, notes + more, [*files, episode.command]
    recording = Recording(
        name=episode.name,
        channels=channels,
        session=episode.session,
        sources=tuple(files),
        sha256=_hash(table) if episode.key is not None else sha256_of_files(files),
        notes=notes,
    )
    _check_overlap(recording)
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


def _channels(
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


def _hash(table: Table) -> str:
    """Return the hash of one episode's arrays: its file holds others too."""
    return sha256(*(np.asarray(column).tobytes() for column in table.columns))


def _check_overlap(recording: Recording) -> None:
    if recording.seconds <= 0.0:
        raise RecordingError(
            f"the commands and the measurements share no time: all channels have begun at "
            f"{recording.start:.6g} s and the first ends at {recording.end:.6g} s",
            where=", ".join(map(str, recording.sources)),
            fix="check that both files belong to one episode and that their clocks agree",
        )
