"""How regular a clock is, and which of its samples can be kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.errors import RecordingError
from morph.record.read.table import Table

MOST_HERTZ = 100.0
"""Readings are thinned to about this rate: what a rollout of a second can tell apart."""


@dataclass(frozen=True, kw_only=True)
class Clock:
    """How a clock ticked."""

    period: float
    """Median interval between samples, s."""
    jitter: float
    """Standard deviation of the intervals, s."""
    longest: float
    """Longest interval, s."""

    @property
    def rate(self) -> float:
        """Samples per second, Hz."""
        return 1.0 / self.period


def clock_of(time: Array) -> Clock:
    """Return how regular a strictly increasing clock of two samples or more is."""
    interval = np.diff(time)
    return Clock(
        period=float(np.median(interval)),
        jitter=float(interval.std()),
        longest=float(interval.max()),
    )


def period(time: Array) -> float:
    """Return the median interval of a clock, s."""
    return float(np.median(np.diff(time)))


def thinned(clock: Array, start: float, end: float) -> Array:
    """Return the times of a clock from one to another, s, at most about `MOST_HERTZ`."""
    clock = clock[(clock >= start) & (clock <= end)]
    if len(clock) < 2:
        return clock
    return clock[:: max(1, int(1.0 / period(clock) / MOST_HERTZ + 0.01))]


def not_repeated(time: Array, table: Table, rows: Integers) -> Mask:
    """Return which samples to keep: the first at each time stamp, shape (samples,).

    Args:
        time: Time stamps, finite, s, shape (samples,).
        table: The file, for errors.
        rows: The file's row of each sample, shape (samples,).

    Raises:
        RecordingError: The clock runs backwards.
    """
    with np.errstate(over="ignore"):
        interval = np.diff(time)
    back = np.flatnonzero(interval < 0.0)
    if len(back):
        at = int(back[0])
        raise RecordingError(
            f"the clock runs backwards at {len(back)} of {len(time)} samples, first "
            f"from {time[at]:.9g} s to {time[at + 1]:.9g} s",
            where=table.place(int(rows[at + 1])),
            fix="split the file here if the logger was started again, or sort its lines by time",
        )
    first = np.ones(len(time), dtype=np.bool_)
    first[1:] = interval > 0.0
    return first
