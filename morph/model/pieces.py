"""Recordings cut where readings are missing, and stretches that stand for long ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.episodes import SHORTEST, Episode, episode
from morph.model.measurement import Measurement
from morph.model.split import between
from morph.record.recording import Recording

STRETCH = 5.0
"""Seconds of the stretches that stand for recordings too long to look at whole."""
SHORTEST_PIECE = 2.0
"""Least seconds of a piece between gaps: the rollouts by which models are compared are no longer
than half of the shortest."""
FEWEST = 20
"""Readings below which a stretch is left out."""


def gaps(time: Array) -> list[tuple[float, float]]:
    """Return where readings are missing: the times of the last before and the first after, s."""
    step = np.diff(time)
    long = step > max(20.0 * float(np.median(step)), 0.2)
    return list(zip(time[:-1][long].tolist(), time[1:][long].tolist(), strict=True))


def pieces(recording: Recording, robot: Robot, step: float) -> list[Episode]:
    """Return what lies between a recording's gaps, each piece as an episode.

    What a robot does without readings for long tells little, and is told badly by a linearised
    model. Pieces of less than `SHORTEST_PIECE` seconds, and whole recordings of less than
    `SHORTEST`, are left out: there may be none.

    Raises:
        RecordingError: A joint's position or an actuator's command is missing.
    """
    channels = [recording.channel(name) for name in Measurement.of(robot).needed]
    start = max(float(channel.time[0]) for channel in channels)
    end = min(float(channel.time[-1]) for channel in channels)
    missing = sorted(gap for channel in channels for gap in gaps(channel.time))
    begins, ends = [start], []
    for last, first in missing:
        ends.append(last)
        begins.append(max(first, begins[-1]))
    results = [
        (begin, until)
        for begin, until in zip(begins, [*ends, end], strict=True)
        if until - begin >= (SHORTEST_PIECE if missing else SHORTEST)
    ]
    if not missing:
        return [episode(recording, robot, step)] if results else []
    laid = (episode(between(recording, *each), robot, step) for each in results)
    return [
        replace(piece, recording=recording, begin=piece.begin + begin - start, whole=False)
        for piece, (begin, _) in zip(laid, results, strict=True)
    ]


def all_pieces(recordings: Sequence[Recording], robot: Robot, step: float) -> list[Episode]:
    """Return the pieces of recordings that are long enough; see `pieces`.

    Raises:
        DiagnosisError: None is.
        RecordingError: A joint's position or an actuator's command is missing.
    """
    results = [piece for recording in recordings for piece in pieces(recording, robot, step)]
    if not results:
        raise DiagnosisError(
            f"none is long enough: one without gaps takes {SHORTEST:g} s, a piece between gaps "
            f"{SHORTEST_PIECE:g} s; friction shows only over as much",
            where=", ".join(recording.name for recording in recordings),
            fix="record for longer, without gaps of more than 0.2 s in a log; without --held-out a "
            "quarter is set aside, and of one recording that leaves two pieces",
        )
    return results


def part(whole: Episode, begin: float, end: float) -> Episode:
    """Return an episode from one time until another, s; its own times count from there."""
    inside = (whole.time >= begin) & (whole.time < end)
    first = round(begin / whole.step)
    steps = slice(first, first + round((end - begin) / whole.step) + 1)
    return replace(
        whole,
        whole=False,
        begin=whole.begin + first * whole.step,
        command=whole.command[steps],
        unsure=whole.unsure[steps],
        time=whole.time[inside] - first * whole.step,
        reading=whole.reading[inside],
        valid=whole.valid[inside],
        attitude=whole.attitude[inside],
        rates=whole.rates.between(begin, end, zero=first * whole.step),
        state=whole.state[inside],
        position=whole.position[inside],
        velocity=whole.velocity[inside],
        acceleration=whole.acceleration[inside],
    )


def stretches(episodes: Sequence[Episode], seconds: float) -> list[Episode]:
    """Return stretches of episodes, evenly spread, that last about `seconds` together.

    No two share a reading. Episodes that are short enough together are returned as they are.
    """
    total = sum(float(e.time[-1]) for e in episodes)
    if total <= seconds:
        return list(episodes)
    cut = []
    for e in episodes:
        lasts = float(e.time[-1])
        count = int(lasts / STRETCH)
        if count < 2:
            cut.append(part(e, 0.0, STRETCH) if count else e)
            continue
        begins = np.linspace(0.0, lasts - STRETCH, count)
        cut += [part(e, begin, begin + STRETCH) for begin in begins.tolist()]
    lasting = sum(float(e.time[-1]) for e in cut)
    count = max(1, min(len(cut), round(len(cut) * seconds / lasting)))
    chosen = [cut[at] for at in np.linspace(0, len(cut) - 1, count).round().astype(int)]
    # A part of a run may lie in a gap of its log.
    return [e for e in chosen if e.whole or len(e.time) >= FEWEST] or chosen
