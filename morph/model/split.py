"""Which recordings are fitted and which are kept shut until the model is chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.record.recording import Recording

LEAD = 0.2
"""Seconds of readings before a part that is cut off by time: the velocity with which its first
rollout starts is smoothed from both sides."""


@dataclass(frozen=True, kw_only=True)
class Split:
    """Recordings to fit and recordings to score."""

    train: tuple[Recording, ...]
    """Fitted and cross-validated."""
    held_out: tuple[Recording, ...]
    """Opened once, after the choice."""
    how: str
    """as named, by session, by episode or by time."""


def split(recordings: Sequence[Recording], held_out: Sequence[Recording] = ()) -> Split:
    """Set a quarter aside: sessions where there are several, else episodes, else time.

    Args:
        recordings: All, or those to fit where `held_out` names the others.
        held_out: Recordings that the user sets aside; empty to let this choose.
    """
    if held_out:
        return Split(train=tuple(recordings), held_out=tuple(held_out), how="as named")
    sessions = list(dict.fromkeys(recording.session for recording in recordings))
    if len(sessions) > 1:
        aside = set(sessions[-max(1, len(sessions) // 4) :])
        return Split(
            train=tuple(r for r in recordings if r.session not in aside),
            held_out=tuple(r for r in recordings if r.session in aside),
            how="by session",
        )
    if len(recordings) > 1:
        count = max(1, len(recordings) // 4)
        return Split(
            train=tuple(recordings[:-count]),
            held_out=tuple(recordings[-count:]),
            how="by episode",
        )
    only = recordings[0]
    middle = only.start + 0.75 * only.seconds
    return Split(
        train=(between(only, only.start, middle),),
        # What was dropped or repaired is told once.
        held_out=(replace(between(only, middle - LEAD, only.end), notes=()),),
        how="by time",
    )


def between(recording: Recording, start: float, end: float) -> Recording:
    """Return a stretch of a recording; a held command keeps what it held at the start."""
    channels = {}
    for name, channel in recording.channels.items():
        first = int(np.searchsorted(channel.time, start, side="left"))
        last = int(np.searchsorted(channel.time, end, side="right"))
        if channel.hold:
            first = max(int(np.searchsorted(channel.time, start, side="right")) - 1, 0)
        keep = slice(first, max(last, first + 1))
        channels[name] = replace(channel, time=channel.time[keep], value=channel.value[keep])
    return replace(recording, channels=channels)
