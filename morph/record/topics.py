"""A bag whose messages name joints and bodies themselves, read without a binding."""

from __future__ import annotations

import numpy as np

from morph.errors import RecordingError
from morph.record.bind import channels_of
from morph.record.quantities import is_channel, parse_channel
from morph.record.read.table import Table, listed
from morph.record.recording import Channel, Note


def read_topics(tables: tuple[Table, ...]) -> tuple[dict[str, Channel], tuple[Note, ...]]:
    """Return the channels that the topics of a bag name, each on its topic's clock.

    A topic with an array of one number is named by its own words: `/elbow/command` is
    `elbow.command`. Other arrays say nothing of what they hold; a note counts them.

    Raises:
        RecordingError: No topic names a channel, two name the same, or the samples
            cannot be used.
    """
    channels: dict[str, Channel] = {}
    notes: tuple[Note, ...] = ()
    source: dict[str, str] = {}
    unbound: list[str] = []
    for table in tables:
        names = _named(table)
        if not names:
            unbound.append(table.topic)
        for name, column in names.items():
            if name in source:
                raise RecordingError(
                    f"both {source[name]!r} and {column!r} are {name}",
                    where=str(table.path),
                    fix="bind one of the two by a recording.toml",
                )
            source[name] = column
        notes += table.notes
        if names and table.clock is not None:
            element = 0 if _is_array(table) else None
            values = {name: table.column(column, element) for name, column in names.items()}
            result, more = channels_of(table.clock, values, table)
            channels, notes = {**channels, **result}, notes + more
    if not channels:
        raise RecordingError(
            f"the messages on {listed(unbound)} do not say what their numbers are",
            where=str(tables[0].path),
            fix='bind them in a recording.toml: "hip.command" = { column = "/topic", element = 0 }',
        )
    if unbound:
        what = f"the arrays on {listed(unbound)} do not say what they hold; a recording.toml may"
        notes += (Note(what=what, where=str(tables[0].path)),)
    return channels, notes


def _named(table: Table) -> dict[str, str]:
    """Return a topic's columns by the channels that they are."""
    if not _is_array(table):
        names = {column.removeprefix(f"{table.topic}:"): column for column in table.names}
        for name in names:
            parse_channel(name, where=table.place(0))
        return names
    name = table.topic.strip("/").replace("/", ".")
    (numbers,) = map(np.asarray, table.columns)
    if len(numbers[0]) != 1 or not is_channel(name):
        return {}
    return {name: table.topic}


def _is_array(table: Table) -> bool:
    return table.names == (table.topic,)
