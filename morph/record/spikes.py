"""Readings that jump out of a track and back: bits lost on a bus, counts an encoder missed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter, percentile_filter

from morph.arrays import Mask
from morph.record.noise import noise
from morph.record.recording import Channel

WINDOW, NEIGHBOURS = 5, 41
"""Samples whose median a reading is compared with, and samples about it that tell how far the track
moves from one to the next."""
STEPS, NOISES = 5.0, 10.0
"""Of those steps, at their ninth decile, and of the noise: a spike is off by more than both add up
to. At an extreme of its motion a reading is off by less than one step."""


def spikes(channel: Channel) -> Mask:
    """Return which readings stand out of those before and after, which go on as if it were not.

    Source: Hampel 1974, J. Am. Stat. Assoc. 69(346), 383-393 (the median as the reference); the
    scale is that of the motion, as a median absolute deviation is nothing where a track rises.

    Args:
        channel: A position over time.

    Returns:
        Shape (samples,).
    """
    value = channel.value
    if len(value) < NEIGHBOURS:
        return np.zeros(len(value), dtype=bool)
    steps = np.abs(np.diff(value, prepend=value[:1]))
    usual = percentile_filter(steps, 90, size=NEIGHBOURS, mode="reflect")
    off = np.abs(value - median_filter(value, size=WINDOW, mode="reflect"))
    return np.asarray(off > STEPS * usual + NOISES * noise(channel.time, value))


def without_spikes(channel: Channel) -> Channel:
    """Return a channel without its spikes."""
    kept = ~spikes(channel)
    return replace(channel, time=channel.time[kept], value=channel.value[kept])
