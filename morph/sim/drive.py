"""Commands as a simulation receives them: held, averaged over steps, changed by effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Effect
from morph.record.recording import Channel


def held(channel: Channel, start: float, step: float, steps: int) -> Array:
    """Return the mean of a held command over each step, shape (steps,).

    The integral of a zero-order hold is piecewise linear, so its differences at
    the steps' edges give exact means on any clock. Before its first sample the
    command holds that sample's value.

    Args:
        channel: A command on its own clock.
        start: When the first step begins, s.
        step: How long each step lasts, s.
        steps: How many there are.
    """
    time, value = channel.time, channel.value
    edges = start + step * np.arange(steps + 1)
    total = np.concatenate([[0.0], np.cumsum(value[:-1] * np.diff(time))])
    inside = np.interp(edges, time, total)
    inside += np.minimum(edges - time[0], 0.0) * value[0]
    inside += np.maximum(edges - time[-1], 0.0) * value[-1]
    return np.asarray(np.diff(inside) / step)


def received(effects: Sequence[Effect], actuator: str, command: Array, step: float) -> Array:
    """Return what an actuator receives of a command under effects, shape (..., steps)."""
    for effect in effects:
        command = effect.command(actuator, command, step)
    return command


def sensed(effects: Sequence[Effect], channel: str, reading: Array) -> Array:
    """Return what a channel reports of a true reading under effects, same shape."""
    for effect in effects:
        reading = effect.sense(channel, reading)
    return reading


def stamped(effects: Sequence[Effect], channel: str, time: Array) -> Array:
    """Return the times that a channel reports under effects, s, same shape."""
    for effect in effects:
        time = effect.stamp(channel, time)
    return time


def unsensed(effects: Sequence[Effect], channel: str, reading: Array) -> Array:
    """Return the truth behind a reading, to first order: exact for an offset."""
    return 2.0 * reading - sensed(effects, channel, reading)
