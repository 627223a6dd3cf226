"""What a robot's logger wrote: one episode of named channels, each on its own clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import JSON, Array
from morph.errors import RecordingError
from morph.extras import require
from morph.tabular import Tabular


@dataclass(frozen=True, kw_only=True)
class Channel:
    """One named signal on its own clock."""

    time: Array
    """When each sample was taken, s, strictly increasing, shape (samples,)."""
    value: Array
    """What was read, SI, finite, shape (samples,)."""
    hold: bool = False
    """Whether the value holds until the next sample, as a command does."""
    guess: float | None = None
    """Of what no sensor read: standard deviation of how far it may be off, in its unit, 0 of what
    follows from other channels. None of a reading."""
    noise: float | None = None
    """Of what other sensors tell, such as a command by a measured effort: standard deviation of its
    error, in its unit, as if it were white noise. None of a reading, which shows its noise."""

    def at(self, times: Array) -> Array:
        """Return the value at any times, s: held for commands, else interpolated.

        Before the first sample and after the last, the nearest one is returned.
        """
        if self.hold:
            index = np.searchsorted(self.time, times, side="right") - 1
            return np.asarray(self.value[np.clip(index, 0, None)])
        return np.interp(times, self.time, self.value)


@dataclass(frozen=True, kw_only=True)
class Note:
    """One thing that was dropped or repaired while reading; shown in the report."""

    what: str
    """What was found and what was done."""
    where: str
    """File, and line or sample."""
    dropped: int = 0
    """Samples dropped."""
    repaired: int = 0
    """Samples repaired."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Recording(Tabular):
    """One episode.

    Channels are named `<part>.<quantity>[.<axis>]`, in SI units: for example
    `shoulder.position` (rad), `shoulder.command` (the actuator's own unit).
    """

    name: str
    """How reports call it."""
    channels: Mapping[str, Channel]
    """Every signal by its canonical name."""
    session: str = ""
    """Same day and same setup; held-out scores split by session."""
    sources: tuple[Path, ...] = ()
    """The files it was read from."""
    sha256: str = ""
    """Hash of those files' contents."""
    notes: tuple[Note, ...] = field(default=())
    """What was dropped or repaired."""

    def __repr__(self) -> str:
        seconds = f", {self.seconds:.4g} s" if self.channels else ""
        return f"Recording({self.name}: {len(self.channels)} channels{seconds})"

    def rows(self) -> list[JSON]:
        """Return one row a channel: samples, their rate in Hz, least and greatest value."""
        return [
            {
                "channel": name,
                "samples": len(each.time),
                "rate": (len(each.time) - 1) / max(float(each.time[-1] - each.time[0]), 1e-300),
                "least": float(np.min(each.value)),
                "greatest": float(np.max(each.value)),
            }
            for name, each in self.channels.items()
        ]

    def to_pandas(self) -> Any:
        """Return a column for each channel over all times, s; empty where it has no sample.

        Raises:
            MissingPackage: pandas is not installed.
        """
        require("notebook", "Recording.to_pandas")
        import pandas

        columns = [
            pandas.Series(each.value, index=each.time, name=name)
            for name, each in self.channels.items()
        ]
        return pandas.concat(columns, axis=1).sort_index().rename_axis("time")

    def plot(self) -> Any:
        """Return a `plotly.graph_objects.Figure` of all channels over time."""
        from plotly import graph_objects

        figure = graph_objects.Figure()
        for name, each in self.channels.items():
            shape = "hv" if each.hold else "linear"
            figure.add_trace(
                graph_objects.Scatter(x=each.time, y=each.value, name=name, line_shape=shape)
            )
        figure.update_layout(title=repr(self), xaxis_title="time, s")
        return figure

    def save(self, path: str | Path) -> None:
        """Write it as CSV, Parquet or NPZ, by the path's ending.

        Raises:
            OutputError: The ending is unknown, or the file cannot be written.
        """
        from morph.record.write import write

        write(self, Path(path))

    def __getitem__(self, channel: str) -> Array:
        """Return a channel's values, shape (samples,).

        Raises:
            RecordingError: There is no such channel.
        """
        return self.channel(channel).value

    def channel(self, name: str) -> Channel:
        """Return a channel with its clock.

        Raises:
            RecordingError: There is no such channel.
        """
        if name not in self.channels:
            raise RecordingError(
                f"there is no channel {name!r}; there are {', '.join(sorted(self.channels))}",
                where=f"recording {self.name}",
                fix="name one of these channels, or bind the missing one in recording.toml",
            )
        return self.channels[name]

    @property
    def start(self) -> float:
        """The latest first sample over the channels, s."""
        return max(float(channel.time[0]) for channel in self.channels.values())

    @property
    def end(self) -> float:
        """The earliest last sample over the measured channels, s; commands hold on."""
        measured = [c for c in self.channels.values() if not c.hold] or list(self.channels.values())
        return min(float(channel.time[-1]) for channel in measured)

    @property
    def seconds(self) -> float:
        """How long all channels last together, s."""
        return self.end - self.start

    @property
    def samples(self) -> int:
        """The number of samples in its longest channel."""
        return max(len(channel.value) for channel in self.channels.values())
