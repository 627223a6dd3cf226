"""Velocities and accelerations from positions on a jittered clock."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.clock import period
from morph.record.recording import Channel

ORDER = 4
"""Order of the low-pass filter, which runs once forwards and once backwards."""
FEWEST = 10
"""The fewest samples that slopes can be taken of."""
CLOSEST = 0.2
"""Samples closer than this share of the period to the one before are passed over."""


def slopes(time: Array, value: Array, cutoff_hz: float) -> tuple[Array, Array, Array]:
    """Return smoothed values, their velocity and their acceleration, at the same times.

    The values are interpolated to the clock's median period, filtered forwards and
    backwards so that nothing is delayed, and differentiated as a quintic spline.
    The response of both passes together is down by 3 dB at the cutoff.

    Source: Robertson and Dowling 2003, J. Electromyography and Kinesiology 13(6),
    for the cutoff of a filter that runs twice.

    Args:
        time: Strictly increasing, s, shape (samples,).
        value: Shape (samples,) or (samples, channels).
        cutoff_hz: Below half the sampling rate.

    Raises:
        RecordingError: The cutoff or the number of samples does not allow it.
    """
    from scipy.interpolate import CubicSpline, make_interp_spline

    if len(time) < FEWEST:
        raise RecordingError(
            f"slopes need at least {FEWEST} samples, there are {len(time)}",
            where="morph.record.slopes",
            fix="use a longer recording",
        )
    # Between samples that almost coincide, noise would look like a huge slope.
    apart = np.diff(time, prepend=-np.inf) > CLOSEST * period(time)
    steps = max(round((time[-1] - time[0]) / period(time)), FEWEST)
    grid = np.linspace(time[0], time[-1], steps + 1)
    raw = CubicSpline(time[apart], value[apart])(grid)
    even = _low_pass(raw, steps / (time[-1] - time[0]), cutoff_hz)
    spline = make_interp_spline(grid, even, k=5)
    return (
        np.asarray(spline(time)),
        np.asarray(spline.derivative(1)(time)),
        np.asarray(spline.derivative(2)(time)),
    )


def band(channel: Channel) -> float:
    """Return the frequency, Hz, within which a position's motion lies, 3 to 15.

    Half as much again as what holds all but a ten-thousandth of its power: above it,
    second derivatives show the clock's jitter and the encoder, not the motion.
    """
    tick = period(channel.time)
    grid = np.arange(channel.time[0], channel.time[-1], tick)
    value = channel.at(grid)
    trend = np.linspace(value[0], value[-1], len(value))
    power = np.abs(np.fft.rfft((value - trend) * np.hanning(len(value)))) ** 2
    if not power.any():
        return 3.0
    share = np.cumsum(power) / power.sum()
    frequency = np.fft.rfftfreq(len(value), tick)
    return float(np.clip(1.5 * frequency[np.searchsorted(share[:-1], 0.9999)], 3.0, 15.0))


def _low_pass(value: Array, rate: float, cutoff_hz: float) -> Array:
    """Return evenly sampled values without what is faster than the cutoff."""
    from scipy.signal import butter, sosfiltfilt

    if not 0.0 < cutoff_hz < rate / 2.0:
        raise RecordingError(
            f"the cutoff is {cutoff_hz:g} Hz; at {rate:.4g} samples a second it lies "
            f"between 0 and {rate / 2.0:.4g} Hz",
            where="morph.record.slopes",
            fix="choose a lower cutoff, or a faster recording",
        )
    # Two passes square the response: each may only be down by 1.5 dB at the cutoff.
    warped = math.tan(math.pi * cutoff_hz / rate) / (math.sqrt(2.0) - 1.0) ** (0.5 / ORDER)
    sections = butter(ORDER, math.atan(warped) * rate / math.pi, fs=rate, output="sos")
    # The filter forgets its start within a few periods of the cutoff.
    pad = min(len(value) - 1, math.ceil(3.0 * rate / cutoff_hz))
    return np.asarray(sosfiltfilt(sections, value, axis=0, padtype="odd", padlen=pad))
