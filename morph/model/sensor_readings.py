"""Simulated sensor readings of positions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array, Mask
from morph.model.measurement import deviation
from morph.model.segments import Segments
from morph.physics.effect import Effect
from morph.sim.drive import sensed, stamped

BEYOND = 0.05
"""Seconds by which motion goes on, at constant acceleration, outside a rollout for late stamps."""


def shown(
    effects: Sequence[Effect],
    segments: Segments,
    position: Array,
    chosen: Mask | slice = slice(None),
) -> Array:
    """Return what sensors report of simulated positions, shape (segments, readings, channels).

    Args:
        effects: What acts on sensors and their clocks, among others.
        segments: When readings were taken.
        position: Shape (segments, steps + 1, nq).
        chosen: Which of the segments, by default all.
    """
    stamp = (segments.before + segments.part)[chosen] * segments.step
    begin = (segments.first[chosen] * segments.step)[:, None]
    measurement, rows = segments.measurement, np.arange(len(position))[:, None]
    space = measurement.coordinates
    read = np.empty((*stamp.shape, space.dofs))

    def there(channel: str, at: int | slice, ball: int = -1) -> Array:
        """Return coordinates, or a rotation, at the times that a channel stamps."""
        late = stamped(effects, channel, begin + stamp) - (begin + stamp)
        time = (stamp - late) / segments.step  # At 2 t - s(t), of a clock that says s(t).
        before = np.clip(time.astype(int), 0, segments.steps - 2)
        part = np.clip(time - before, -BEYOND / segments.step, 2.0 + BEYOND / segments.step)
        one, two, three = (position[rows, before + k, at] for k in (0, 1, 2))
        if ball >= 0:
            measured, part = segments.attitude[chosen][..., ball, :], part[..., None]
            one, two, three = (deviation(each, measured) for each in (one, two, three))
        bend = three - 2.0 * two + one
        return np.asarray(one + part * (two - one) + 0.5 * part * (part - 1.0) * bend)

    for at, dof in zip(space.straight.tolist(), space.dof.tolist(), strict=True):
        channel = measurement.channels[dof]
        read[..., dof] = sensed(effects, channel, there(channel, at))
    for ball, (at, dof) in enumerate(space.balls):
        channel = measurement.channels[dof]
        read[..., dof : dof + 3] = there(channel, slice(at, at + 4), ball)
    return read
