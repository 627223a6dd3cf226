"""Velocities of hinges and slides that sensors of their own read."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_dilation, median_filter

from morph.arrays import Array, Integers, Mask
from morph.body.robot import Robot
from morph.errors import RecordingError
from morph.record.clock import period, thinned
from morph.record.noise import FEWEST, noise
from morph.record.recording import Channel, Note, Recording
from morph.record.slopes import band, slopes

FARTHEST = 1e4
"""rad/s or m/s: what no joint's velocity exceeds."""
LAGS = range(-3, 11)
"""Samples before a velocity whose positions it may have been computed from."""
COMPUTED = 0.5
"""Least variance about the best combination of these, over that by their noise in it, of a sensor
of its own: it would be 1 of one without noise."""
APART = 4.0
"""Mean squared difference from the position's rate, over that which the noise of both explains,
from which the sensor errs by more than its noise."""
CORNER = 16.0
"""Second difference of velocities, beyond those about it and over their noise, at which a force has
jumped: the step of a simulation in which that was interpolates a velocity wrongly."""
ABOUT = 7
"""Second differences of which the median is that of a smooth motion."""
QUIETEST = 1e-4
"""rad/s or m/s: least noise that a sensor is credited with."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointRates:
    """What sensors of velocity read in one episode."""

    dofs: Integers
    """Degrees of freedom whose velocity they read, shape (sensors,)."""
    time: Array
    """When, s from the episode's start, shape (readings,)."""
    reading: Array
    """rad/s or m/s, shape (readings, sensors); anything where not `valid`."""
    valid: Mask
    """Which were read then, same shape."""
    noise: Array
    """Standard deviation of their noise, shape (sensors,)."""

    @classmethod
    def of(cls, recording: Recording, robot: Robot, start: float, end: float) -> JointRates:
        """Return all readings of velocities of a recording between two of its times, s."""
        names = [name for name in _joints(robot) if f"{name}.velocity" in recording.channels]
        dofs, tracks, noises = [], [], []
        for name in names:
            track = recording.channel(f"{name}.velocity")
            clock = thinned(track.time, start, end)
            if len(track.time) >= FEWEST and len(clock):
                dofs.append(_joints(robot)[name])
                noises.append(max(noise(track.time, track.value), QUIETEST))
                tracks.append(Channel(time=clock - start, value=track.at(clock)))
        none: Array = np.zeros(0)
        time = np.unique(np.concatenate([none, *(track.time for track in tracks)]))
        reading, valid = (np.zeros((len(time), len(dofs)), dtype=kind) for kind in (float, bool))
        for at, track in enumerate(tracks):
            there = np.searchsorted(time, track.time)
            reading[there, at], valid[there, at] = track.value, ~_corners(track.value, noises[at])
        return cls(
            dofs=np.array(dofs, dtype=int), time=time, reading=reading, valid=valid,
            noise=np.array(noises),
        )  # fmt: skip

    def between(self, begin: float, end: float, *, zero: float) -> JointRates:
        """Return those from one time until another, s; their times count from `zero`."""
        inside = (self.time >= begin) & (self.time < end)
        return replace(
            self,
            time=self.time[inside] - zero,
            reading=self.reading[inside],
            valid=self.valid[inside],
        )


def with_own_rates(recording: Recording, robot: Robot) -> Recording:
    """Return a recording without velocities that are no readings of a sensor that is right, noted.

    Those computed from positions would be taken for readings of a second sensor. A sensor whose
    scale or lag makes it differ from the rate of the position would accuse the robot. Joints that
    follow others keep none.

    Raises:
        RecordingError: A velocity is none that a joint has.
    """
    channels, notes = dict(recording.channels), []
    followers = {joint.name for joint in robot.joints if joint.mimic is not None}
    for name in _joints(robot):
        velocity, position = (channels.get(f"{name}.{what}") for what in ("velocity", "position"))
        if velocity is None:
            continue
        fastest = float(np.abs(velocity.value).max())
        if fastest > FARTHEST:
            raise RecordingError(
                f"a velocity of {fastest:.3g} is none that a joint has",
                where=f"recording {recording.name}, {name}.velocity",
                fix="see that it is in rad/s or m/s, or leave the column out of recording.toml",
            )
        if name in followers:
            why = "is that of the joint that it follows"
        elif apart := _apart(velocity, position):
            why = f"differs from the rate of its position by {apart:.2g} beyond the noise of both"
        elif _computed(velocity, position):
            why = "was computed from positions, or cannot be told from that"
        else:
            if len(velocity.time) < FEWEST:
                continue
            sigma = max(noise(velocity.time, velocity.value), QUIETEST)
            if count := int(_corners(velocity.value, sigma).sum()):
                notes.append(
                    Note(
                        what=f"{count} of {len(velocity.value)} velocities of {name}, beside jumps "
                        "of a force, are left out",
                        where=f"recording {recording.name}",
                        dropped=count,
                    )
                )
            continue
        del channels[f"{name}.velocity"]
        notes.append(
            Note(
                what=f"the velocity of {name} {why}: it is not read",
                where=f"recording {recording.name}",
            )
        )
    return replace(recording, channels=channels, notes=(*recording.notes, *notes))


def _corners(velocity: Array, sigma: float) -> Mask:
    """Return at which readings, and beside which, a velocity turns at once, shape (samples,)."""
    second = np.zeros_like(velocity)
    second[1:-1] = np.diff(velocity, n=2)
    sharp = np.abs(second - median_filter(second, ABOUT)) > CORNER * sigma
    return np.asarray(binary_dilation(sharp))


def _joints(robot: Robot) -> dict[str, int]:
    """Return the degree of freedom of each hinge and slide, by its name."""
    sizes = {"free": 6, "ball": 3}
    first = np.cumsum([0, *(sizes.get(joint.kind, 1) for joint in robot.joints)])
    return {
        joint.name: int(dof)
        for joint, dof in zip(robot.joints, first, strict=False)
        if joint.kind not in sizes
    }


def _computed(velocity: Channel, position: Channel | None) -> bool:
    """Return whether a velocity is a combination of the positions before and after, noise and all.

    Of a sensor of its own the best such combination errs by the sensor's noise and by that of the
    positions in it. Of what was computed from these it errs by less than the latter.
    """
    if position is None or position.guess is not None:
        return False
    if min(len(position.time), len(velocity.time)) < 4 * len(LAGS):
        return True
    tick = period(position.time)
    inside = slice(max(LAGS), min(LAGS))
    columns = [
        np.interp(velocity.time - lag * tick, position.time, position.value)[inside] for lag in LAGS
    ]
    whole = np.stack([*columns, np.ones_like(columns[0])], axis=1)
    weights, *_ = np.linalg.lstsq(whole, velocity.value[inside], rcond=None)
    left = float(np.sum((velocity.value[inside] - whole @ weights) ** 2))
    left /= len(whole) - len(weights)
    by_noise = float(np.sum(weights[:-1] ** 2)) * noise(position.time, position.value) ** 2
    return left < COMPUTED * by_noise or left == 0.0


def _apart(velocity: Channel, position: Channel | None) -> float:
    """Return how far a velocity is from the rate of a position, RMS, beyond the noise of both."""
    if position is None or position.guess is not None:
        return 0.0
    hertz, rng = _cutoff(velocity, position), np.random.default_rng(0)
    inside = _inside(velocity.time, hertz)

    def band_of(values: Array) -> Array:
        return slopes(velocity.time, values, hertz)[0][inside]

    def rate_of(values: Array) -> Array:
        rates = slopes(position.time, values, hertz)[1]
        return np.interp(velocity.time[inside], position.time, rates)

    off = band_of(velocity.value) - rate_of(position.value)
    pairs = (velocity, band_of), (position, rate_of)
    by_noise = [
        noise(each.time, each.value) ** 2
        * np.mean(passed(rng.standard_normal(len(each.time))) ** 2)
        for each, passed in pairs
    ]
    error, explained = float(np.mean(off**2)), float(sum(by_noise))
    return math.sqrt(error - explained) if error > APART * explained else 0.0


def _inside(time: Array, hertz: float) -> Mask:
    """Return which samples a low-pass filter knows from both sides, shape (samples,)."""
    edge = min(1.0 / hertz, 0.25 * float(np.ptp(time)))
    return np.asarray((time >= time[0] + edge) & (time <= time[-1] - edge))


def _cutoff(velocity: Channel, position: Channel) -> float:
    """Return the frequency, Hz, up to which both are compared."""
    return min(band(position), 0.2 / period(position.time), 0.2 / period(velocity.time))
