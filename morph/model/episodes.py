"""Recordings laid on a simulation's grid: commands by step, readings, smooth motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.measurement import Measurement
from morph.model.split import between
from morph.record.noise import noise
from morph.record.recording import Channel, Recording
from morph.record.slopes import slopes
from morph.sim.drive import completed, held

MOST_HERTZ = 100.0
"""Readings are thinned to about this rate: what a rollout of a second can tell apart."""
QUIETEST = 1e-5
"""rad or m: least noise that a sensor is credited with."""
STRETCH = 5.0
"""Seconds of the stretches that stand for recordings too long to look at whole."""
SHORTEST, SHORTEST_PIECE = 0.5, 2.0
"""Least seconds of an episode, as in less friction does not show, and of a piece between gaps: the
rollouts by which models are compared are no longer than half of the shortest."""
FEWEST = 20
"""Readings below which a stretch is left out."""
STATE_HERTZ = 15.0
"""Band of the motion that a rollout's start is read from."""


def band(channel: Channel) -> float:
    """Return the frequency, Hz, within which a position's motion lies, 3 to 15.

    Half as much again as what holds all but a ten-thousandth of its power: above it,
    second derivatives show the clock's jitter and the encoder, not the motion.
    """
    period = float(np.median(np.diff(channel.time)))
    grid = np.arange(channel.time[0], channel.time[-1], period)
    value = channel.at(grid)
    trend = np.linspace(value[0], value[-1], len(value))
    power = np.abs(np.fft.rfft((value - trend) * np.hanning(len(value)))) ** 2
    if not power.any():
        return 3.0
    share = np.cumsum(power) / power.sum()
    frequency = np.fft.rfftfreq(len(value), period)
    return float(np.clip(1.5 * frequency[np.searchsorted(share[:-1], 0.9999)], 3.0, 15.0))


@dataclass(frozen=True, kw_only=True)
class Episode:
    """One recording of a robot whose joints are all measured."""

    measurement: Measurement
    """What its readings are of."""
    recording: Recording
    """Where it came from."""
    step: float
    """Seconds a step of simulation."""
    command: Array
    """Mean command about the start of each step, shape (steps, actuators)."""
    unsure: Array
    """Standard deviation of commands where the logger lost samples, zero elsewhere, same shape.
    Of each step alone: it is larger than that of their mean over the time of one sample."""
    time: Array
    """When readings were taken, s from the start, shape (readings,)."""
    reading: Array
    """What each channel reads, shape (readings, channels)."""
    attitude: Array
    """Measured orientations of what moves freely, shape (readings, balls, 4)."""
    noise: Array
    """Standard deviation of each reading's noise, shape (channels,)."""
    state: Array
    """Positions, then velocities, lightly smoothed, shape (readings, nq + nv)."""
    state_cutoff: float
    """Frequency, Hz, above which motion is taken for noise in `state`."""
    position: Array
    """Positions smoothed to the band of the motion, shape (readings, nq)."""
    velocity: Array
    """How they change, per s, shape (readings, nv)."""
    acceleration: Array
    """How that changes, per s2, same shape."""
    cutoff: float
    """Frequency, Hz, above which motion is taken for noise in the three above."""
    begin: float | None = None
    """Seconds of the recording at which it begins, of a part of one; None of a whole."""

    @property
    def name(self) -> str:
        """How reports call it."""
        name = self.recording.name
        return name if self.begin is None else f"{name} from {self.begin:.1f} s"

    @property
    def session(self) -> str:
        """Same day and same setup."""
        return self.recording.session


def step_for(recordings: Sequence[Recording], robot: Robot) -> float:
    """Return the seconds a step: whole parts or multiples of the clock's median period.

    About 4 ms, 2.5 ms where servos add stiff damping: with the starts fitted, the
    error of a semi-implicit step is of second order, (w h)^2 / 24 of the period of a
    motion at w rad/s, below 1e-4 at 10 rad/s.
    """
    first = Measurement.of(robot).needed[0]
    period = float(np.median([np.median(np.diff(r.channel(first).time)) for r in recordings]))
    wanted = 0.0025 if any(a.kind == "position" for a in robot.actuators) else 0.004
    if period > wanted:
        return period / float(np.ceil(period / wanted - 0.1))
    return period * max(1.0, float(np.floor(wanted / period + 0.1)))


def episode(recording: Recording, robot: Robot, step: float) -> Episode:
    """Lay one recording on the grid of a simulation.

    Raises:
        RecordingError: A joint's position or an actuator's command is missing.
        DiagnosisError: The recording is shorter than half a second.
    """
    measurement = Measurement.of(robot)
    tracks = measurement.tracks(recording)
    commands = [recording.channel(f"{actuator.name}.command") for actuator in robot.actuators]
    start = max(float(track.time[0]) for track in tracks)
    end = min(float(track.time[-1]) for track in tracks)
    if end - start < SHORTEST:
        raise DiagnosisError(
            f"it lasts {end - start:.3g} s; friction shows only over half a second or more",
            where=f"recording {recording.name}",
            fix="record for longer; without --held-out a quarter of a recording is set aside",
        )
    clock = tracks[0].time
    clock = clock[(clock >= start) & (clock <= end)]
    period = float(np.median(np.diff(clock)))
    light = min(0.2 / period, STATE_HERTZ)
    cutoff = min(light, max(band(track) for track in tracks))
    kept = clock[:: max(1, int(1.0 / period / MOST_HERTZ + 0.01))]
    quick, smooth = (_moving(measurement, tracks, kept, hertz) for hertz in (light, cutoff))
    raw = np.stack([np.interp(kept, track.time, track.value) for track in tracks], axis=1)
    steps = int((end - start) / step + 1e-6)
    # A semi-implicit step is a leapfrog: the force of step n carries the velocity from
    # half a step before it to half a step after, so its command is centred on it.
    drive, unsure = [np.zeros((steps, 0))], [np.zeros((steps, 0))]
    for channel in commands:
        whole, error = completed(channel)
        drive.append(held(whole, start - 0.5 * step, step, steps)[:, None])
        # One error a sample acts as an independent one of each of its steps.
        of_steps = error * np.sqrt(max(1.0, float(np.median(np.diff(whole.time))) / step))
        lost = replace(channel, time=whole.time, value=of_steps, hold=True)
        unsure.append(lost.at(start + step * np.arange(steps, dtype=float))[:, None])
    return Episode(
        recording=recording,
        step=step,
        command=np.concatenate(drive, axis=1),
        unsure=np.concatenate(unsure, axis=1),
        time=kept - start,
        measurement=measurement,
        reading=measurement.spread(raw),
        attitude=measurement.attitude(raw),
        noise=_floored(measurement.noise(np.array([noise(t.time, t.value) for t in tracks]))),
        state=np.concatenate(quick[:2], axis=1),
        state_cutoff=light,
        position=smooth[0],
        velocity=smooth[1],
        acceleration=smooth[2],
        cutoff=cutoff,
    )


def _moving(
    measurement: Measurement, tracks: Sequence[Channel], times: Array, cutoff: float
) -> tuple[Array, Array, Array]:
    """Return smoothed positions, velocities and accelerations at some times."""
    parts = [slopes(track.time, track.value, cutoff) for track in tracks]
    columns = [
        np.stack(
            [np.interp(times, t.time, p[k]) for t, p in zip(tracks, parts, strict=True)], axis=1
        )
        for k in range(3)
    ]
    return measurement.motion(*columns)


def _floored(noises: Array) -> Array:
    """Return noises, none so small that one still or simulated joint outvotes the others."""
    return np.maximum(noises, max(QUIETEST, 0.01 * float(noises.max())))


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
    found = [
        (begin, until)
        for begin, until in zip(begins, [*ends, end], strict=True)
        if until - begin >= (SHORTEST_PIECE if missing else SHORTEST)
    ]
    if not missing:
        return [episode(recording, robot, step)] if found else []
    laid = (episode(between(recording, *each), robot, step) for each in found)
    return [
        replace(piece, recording=recording, begin=begin - start)
        for piece, (begin, _) in zip(laid, found, strict=True)
    ]


def fills(episode: Episode) -> list[str]:
    """Return in how many places commands were interpolated, as the logger lost them, in words."""
    lost = (episode.unsure > 0.0).any(axis=1)
    count = int(np.count_nonzero(np.diff(lost, prepend=False) & lost))
    return [f"commands that the logger lost are interpolated, gaps: {count}"] if count else []


def part(whole: Episode, begin: float, end: float) -> Episode:
    """Return an episode from one time to another, s; its own times count from there."""
    inside = (whole.time >= begin) & (whole.time <= end)
    first = round(begin / whole.step)
    steps = slice(first, first + round((end - begin) / whole.step) + 1)
    return replace(
        whole,
        begin=(whole.begin or 0.0) + first * whole.step,
        command=whole.command[steps],
        unsure=whole.unsure[steps],
        time=whole.time[inside] - first * whole.step,
        reading=whole.reading[inside],
        attitude=whole.attitude[inside],
        state=whole.state[inside],
        position=whole.position[inside],
        velocity=whole.velocity[inside],
        acceleration=whole.acceleration[inside],
    )


def stretches(episodes: Sequence[Episode], seconds: float) -> list[Episode]:
    """Return stretches of episodes, evenly spread, that last about `seconds` together.

    Episodes that are short enough together are returned as they are.
    """
    total = sum(float(e.time[-1]) for e in episodes)
    if total <= seconds:
        return list(episodes)
    count = max(1, round(seconds / STRETCH))
    chosen = []
    for begin in np.linspace(0.0, total - STRETCH, count):
        for e in episodes:
            if begin < float(e.time[-1]):
                break
            begin -= float(e.time[-1])
        begin = min(begin, max(0.0, float(e.time[-1]) - STRETCH))
        stretch = part(e, begin, begin + STRETCH)
        if len(stretch.time) >= FEWEST:
            chosen.append(stretch)
    return chosen
