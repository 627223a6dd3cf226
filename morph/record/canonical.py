"""A file whose columns carry canonical names in SI, read without a binding."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.bind import channels_of, check_overlap, hash_of_arrays
from morph.record.binding import stem_of
from morph.record.quantities import parse_channel
from morph.record.read.any import read_all
from morph.record.read.file import hash_of
from morph.record.read.table import Table, listed
from morph.record.recording import Channel, Note, Recording
from morph.record.topics import read_topics

CLOCK = ".time"
"""The ending of a channel's own clock."""


def read_canonical(path: Path) -> tuple[Recording, ...]:
    """Return the recordings in a file with canonical names: one, or one per group of HDF5.

    A channel may stand beside its own clock, `<channel>.time`. In a table of rows the cells below
    the last sample of each clock are then empty.
    The topics of a bag have clocks of their own.

    Raises:
        RecordingError: A column is no channel, there is no clock, or the samples
            cannot be used.
    """
    return tuple(_episode(path, key, tables) for key, tables in read_all(path))


def _episode(path: Path, key: str | None, tables: tuple[Table, ...]) -> Recording:
    if tables[0].clock is not None:
        channels, notes = read_topics(tables)
    else:
        channels, notes = _channels(tables[0])
    recording = Recording(
        name=stem_of(path) + (f"_{key}" if key is not None else ""),
        channels=channels,
        sources=(path,),
        sha256=hash_of_arrays(tables) if key is not None else hash_of((path,)),
        notes=notes,
    )
    if tables[0].clock is not None:
        check_overlap(recording)
    return recording


def _channels(table: Table) -> tuple[dict[str, Channel], tuple[Note, ...]]:
    path = table.path
    names = [name for name in table.names if name != "time" and not _is_clock(name, table)]
    if not names or ("time" not in table.names and len(names) == len(table.names)):
        raise RecordingError(
            "the file has no channel names, or no column 'time'; its columns are "
            + (listed(table.names) or "not named"),
            where=table.place(0) if table.lines is None else f"{path}, line 1",
            fix="name the columns time, <joint>.position, ... in SI, or say which is which in a "
            "recording.toml: docs/recordings.md has one to copy",
        )
    where = f"{path}, line 1" if table.lines is not None else str(path)
    for name in names:
        parse_channel(name, where=where)
    channels: dict[str, Channel] = {}
    notes, groups = table.notes, _groups(names, table)
    for clock, group in groups.items():
        time = table.column(clock)
        values = {name: table.column(name) for name in group}
        for name, value in values.items():
            if len(value) != len(time):
                raise RecordingError(
                    f"{name} has {len(value)} samples, its clock {clock!r} has {len(time)}",
                    where=str(path),
                    fix=f"give it a clock of its own, {name}{CLOCK}",
                )
        if len(groups) > 1:
            rows = _rows([time, *values.values()])
            time, values = time[:rows], {name: value[:rows] for name, value in values.items()}
        cleaned, result = channels_of(time, values, table)
        channels, notes = {**channels, **cleaned}, notes + result
    return {name: channels[name] for name in names}, notes


def _rows(columns: Sequence[Array]) -> int:
    """Return how many rows there are down to the last in which a cell is filled."""
    filled = np.flatnonzero(~np.isnan(columns).all(axis=0))
    return int(filled[-1]) + 1 if len(filled) else 0


def _is_clock(name: str, table: Table) -> bool:
    return name.endswith(CLOCK) and name.removesuffix(CLOCK) in table.names


def _groups(names: list[str], table: Table) -> dict[str, list[str]]:
    """Return the channels by the name of their clock."""
    groups: dict[str, list[str]] = {}
    for name in names:
        own = f"{name}{CLOCK}"
        groups.setdefault(own if own in table.names else "time", []).append(name)
    return groups
