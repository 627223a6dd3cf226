"""How noisy a sensor is, from one recording of it."""

from __future__ import annotations

import math
import zlib
from dataclasses import replace

import numpy as np

from morph.arrays import Array, Mask
from morph.errors import RecordingError
from morph.record.recording import Recording

FEWEST = 10
"""Least number of samples."""
POINTS = 4
"""Samples that are compared at a time: no parabola shows in their third differences."""

MOVES = 10.0
"""Standard deviations of the noise over which a moving joint's readings spread: those of a joint at
rest, of 1e5 of a normal distribution, over 9, and of a counter between two steps over 3.5."""


def moves(time: Array, value: Array) -> bool:
    """Return whether readings change by more than their noise."""
    spread = float(np.ptp(value)) if len(value) else 0.0
    return spread > (MOVES * noise(time, value) if len(value) >= FEWEST else 0.0)


def noise(time: Array, value: Array) -> float:
    """Return the standard deviation of a sensor's noise.

    The third divided difference of four neighbours is zero for any motion that is
    a parabola over them, however the clock jitters; its weights, scaled to norm 1
    (to norm sqrt(20) they are 1, -3, 3, -1 on an even clock), leave the noise. The
    median of its magnitude is 0.6745 standard deviations, and ignores rare jumps.
    Never below what rounding alone does: a step / sqrt(12).

    Source: Rousseeuw and Croux 1993, J. Am. Stat. Assoc. 88(424), for the median;
    Widrow, Kollar and Liu 1996, IEEE Trans. Instrum. Meas. 45(2), for rounding.

    Args:
        time: Strictly increasing, s, shape (samples,).
        value: Shape (samples,).

    Raises:
        RecordingError: There are fewer than `FEWEST` samples.
    """
    if len(value) < FEWEST:
        raise RecordingError(
            f"noise needs at least {FEWEST} samples, there are {len(value)}",
            where="morph.record.noise",
            fix="use a longer recording",
        )
    windows = np.lib.stride_tricks.sliding_window_view
    around = windows(time, POINTS)
    gap = around[:, :, None] - around[:, None, :]
    gap = gap / np.abs(gap).max(axis=(1, 2), keepdims=True)
    gap[:, range(POINTS), range(POINTS)] = 1.0
    weight = 1.0 / gap.prod(axis=2)
    weight /= np.linalg.norm(weight, axis=1, keepdims=True)
    # Taking off a constant first keeps the rounding of large values out.
    difference = (weight * windows(value - np.median(value), POINTS)).sum(axis=1)
    spread = float(np.median(np.abs(difference))) / 0.6744897501960817
    return max(spread, quantum(value) / math.sqrt(12.0))


def quantum(value: Array) -> float:
    """Return the step that a sensor counts in; 0 if it is not clearly quantised.

    Clearly: values return, and 95 % of the differences between those that occur are
    whole multiples of the smallest, to within a twentieth of it.
    """
    levels = np.unique(value)
    if len(levels) < 2 or len(levels) > 0.9 * len(value):
        return 0.0
    steps = np.diff(levels)
    # One level written with two roundings is not a step.
    steps = steps[steps > 1e-9 * float(levels[-1] - levels[0])]
    step = float(steps.min())
    count = steps / step
    whole: Mask = np.abs(count - np.round(count)) < 0.05
    return step if float(whole.mean()) > 0.95 else 0.0


def noisy(recording: Recording, sigma: float) -> Recording:
    """Return a recording of which positions and orientations are read with white noise.

    Velocities go, as no sensor of these reads them.

    Args:
        recording: What is read without noise, such as a simulation's.
        sigma: Standard deviation, rad or m; of the three components of an orientation's error. Zero
            leaves the recording as it is.

    Raises:
        RecordingError: `sigma` is negative or not finite.
    """
    if not (math.isfinite(sigma) and sigma >= 0.0):
        raise RecordingError(
            f"noise of a standard deviation of {sigma:g} is out of range",
            where=f"recording {recording.name}",
            fix="give 0 or more, rad or m",
        )
    if sigma == 0.0:
        return recording
    # Runs of other names have other noise.
    rng, channels = np.random.default_rng(zlib.crc32(recording.name.encode())), {}
    for name, channel in recording.channels.items():
        kind = name.rpartition(".")[0] if name[-2:-1] == "." else name
        if kind.endswith("velocity"):
            continue
        if kind.endswith((".position", ".orientation")):
            # A rotation of a small angle changes a quaternion by half of it.
            size = 0.5 * sigma if kind.endswith(".orientation") else sigma
            added = size * rng.standard_normal(len(channel.value))
            channels[name] = replace(channel, value=channel.value + added)
        else:
            channels[name] = channel
    return replace(recording, channels=channels)
