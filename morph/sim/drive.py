"""Commands as a simulation receives them: held, averaged over steps, changed by effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import uniform_filter1d

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.record.recording import Channel

REGULAR, MOST_LOST = 0.9, 3
"""Share of a clock's periods that are within 30 % of their median where samples that were lost can
be told from a command that did not change; and how many in a row are filled in."""
AROUND = 21
"""Samples about a lost one from which the error of its interpolation is estimated."""


def completed(channel: Channel) -> tuple[Channel, Array]:
    """Return a command with the samples that its logger lost, and the error of each sample.

    A row that is missing from a log at a regular rate is no command that was held for twice as
    long: what was sent is interpolated, by piecewise cubics that do not overshoot. The error of
    that is what the same interpolation of every other sample errs nearby.

    Returns:
        The channel, and the standard deviation of each of its samples, zero where it was logged.
    """
    time, value = channel.time, channel.value
    ratio = np.diff(time) / np.median(np.diff(time)) if len(time) > AROUND else np.ones(1)
    lost = np.rint(ratio).astype(int) - 1
    lost[(lost < 1) | (lost > MOST_LOST)] = 0
    if np.mean(np.abs(ratio - 1.0) < 0.3) < REGULAR or not lost.any():
        return channel, np.zeros(len(time))
    error = np.empty(len(time))
    for first in (0, 1):
        others = slice(1 - first, None, 2)
        rest = PchipInterpolator(time[others], value[others], extrapolate=False)
        error[first::2] = value[first::2] - rest(time[first::2])
    local = np.sqrt(np.maximum(uniform_filter1d(np.nan_to_num(error) ** 2, AROUND), 0.0))
    gaps = np.flatnonzero(lost)
    inside = [
        time[at] + (time[at + 1] - time[at]) * np.arange(1, lost[at] + 1) / (lost[at] + 1)
        for at in gaps
    ]
    added = np.concatenate(inside)
    # The error of an interpolation grows with the square of the gap.
    unsure = np.repeat(local[gaps] * (0.5 * (lost[gaps] + 1)) ** 2, lost[gaps])
    whole = np.argsort(np.concatenate([time, added]), kind="stable")
    values = np.concatenate([value, PchipInterpolator(time, value)(added)])
    filled = replace(channel, time=np.concatenate([time, added])[whole], value=values[whole])
    return filled, np.concatenate([np.zeros(len(time)), unsure])[whole]


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


def all_received(effects: Sequence[Effect], robot: Robot, command: Array, step: float) -> Array:
    """Return what all actuators receive of commands under effects, shape (..., steps, actuators).

    Args:
        effects: What may change commands on their way.
        robot: Whose actuators they are told, in the order of their columns.
        command: Shape (..., steps, actuators).
        step: Seconds a step.
    """
    given = np.array(command)
    for at, actuator in enumerate(robot.actuators):
        given[..., at] = received(effects, actuator.name, command[..., at], step)
    return given


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
    """Return the truth behind a reading, of sensors with an offset and a scale."""
    zero, one = (sensed(effects, channel, np.full(1, each)) for each in (0.0, 1.0))
    return (reading - zero) / (one - zero)
