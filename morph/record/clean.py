"""Which samples of a file are fit to use; what is not is dropped and counted, or refused."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import RecordingError
from morph.record.clock import not_repeated
from morph.record.read.table import Table
from morph.record.recording import Note

MOST_MISSING = 0.01
"""The greatest fraction of samples that may be missing; one sample always may."""
FEWEST = 10
"""The fewest samples that make an episode."""


def clean(
    time: Array, values: Mapping[str, Array], table: Table
) -> tuple[Array, dict[str, Array], tuple[Note, ...]]:
    """Return a file's clock and channels without the samples that cannot be used.

    A sample is dropped from all channels when its time stamp repeats the one
    before, or when its time or a value is NaN and no more than `MOST_MISSING` are.

    Args:
        time: Time stamps, s, shape (samples,).
        values: Each channel, SI, shape (samples,).
        table: The file, for errors.

    Raises:
        RecordingError: A value is infinite, too many are NaN, the clock runs
            backwards, or fewer than `FEWEST` samples are left.
    """
    signals = {"time": time, **values}
    for name, signal in signals.items():
        _refuse_infinite(name, signal, table)
    keep, notes = _without_missing(signals, table)
    first = not_repeated(time[keep], table, keep)
    if not first.all():
        repeated = keep[~first]
        notes.append(
            Note(
                what=f"{len(repeated)} of {len(time)} samples repeat a time stamp; "
                "the first at each stamp is kept",
                where=table.place(*repeated.tolist()),
                dropped=len(repeated),
            )
        )
        keep = keep[first]
    if len(keep) < FEWEST:
        again = int((~first).sum())
        raise RecordingError(
            f"{len(keep)} samples are left of {len(time)}; an episode needs at least {FEWEST}"
            + f"; {again} repeat a time stamp" * bool(again),
            where=str(table.path),
            fix="write times as 64-bit floats or as seconds from the start: a 32-bit float has "
            "seven digits"
            if again > len(first) // 2
            else "record a longer episode, or leave this file out",
        )
    return time[keep], {name: value[keep] for name, value in values.items()}, tuple(notes)


def _refuse_infinite(name: str, signal: Array, table: Table) -> None:
    infinite = np.flatnonzero(np.isinf(signal))
    if len(infinite):
        raise RecordingError(
            f"{name} is infinite in {len(infinite)} of {len(signal)} samples",
            where=table.place(*infinite.tolist()),
            fix="remove these samples, or correct what writes them",
        )


def _without_missing(signals: Mapping[str, Array], table: Table) -> tuple[Integers, list[Note]]:
    """Return the rows in which nothing is NaN, and what was dropped."""
    holes = {name: np.isnan(signal) for name, signal in signals.items()}
    missing = np.logical_or.reduce(list(holes.values()))
    count, total = int(missing.sum()), len(missing)
    keep = np.flatnonzero(~missing)
    if not count:
        return keep, []
    blamed = ", ".join(name for name, hole in holes.items() if hole.any())
    where = table.place(*np.flatnonzero(missing).tolist())
    what = f"{blamed}: NaN or missing in {count} of {total} samples"
    allowed = max(1, math.floor(MOST_MISSING * total))
    if count > allowed:
        raise RecordingError(
            f"{what}; at most {allowed} may be dropped",
            where=where,
            fix="remove these samples from the file, or interpolate them; a channel that is not "
            "needed can be left out of recording.toml",
        )
    return keep, [Note(what=f"{what}; these samples are dropped", where=where, dropped=count)]
