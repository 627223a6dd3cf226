"""Shapes of commands over time, each of a kind that other laws show under."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot

LOWEST, HIGHEST = 0.2, 4.0
"""Hz: the band of quick motions."""
WAVES = 6
"""Sines of a quick motion."""
RETURNS = 2.0
"""How often a slow motion returns."""
HELD = 1.5
"""Seconds that each step of a command is held."""
COAST = 4.0
"""Seconds of a drive and of the coasting after it."""


def waves(robot: Robot, time: Array, seed: int) -> Iterator[tuple[str, Array]]:
    """Yield commands of each kind, within -1 and 1, shape (samples, actuators)."""
    rng = np.random.default_rng(seed)
    count = len(robot.actuators)
    quick = np.stack([quick_wave(time, rng) for _ in range(count)], axis=1)
    yield "quick", quick
    shift = rng.uniform(0.0, 1.0, count)
    often = RETURNS / time[-1] * (1.0 + 0.3 * rng.uniform(-1.0, 1.0, count))
    turns = often * time[:, None] + shift
    # A triangle: the same speed both ways, so that friction turns its sign and nothing else.
    triangle = 4.0 * np.abs((turns % 1.0) - 0.5) - 1.0
    yield "slow", triangle * _begun(time)
    levels = rng.uniform(-1.0, 1.0, (int(time[-1] / HELD) + 1, count))
    yield "steps", levels[(time / HELD).astype(int)]
    if all(each.kind == "motor" for each in robot.actuators):
        driving = (time % (2.0 * COAST) < COAST)[:, None]
        yield "coast", quick * driving
    if count > 1:
        for at, actuator in enumerate(robot.actuators):
            alone = np.zeros_like(quick)
            alone[:, at] = quick[:, at]
            yield f"one: {actuator.name}", alone


def quick_wave(
    time: Array,
    rng: np.random.Generator,
    lowest: float = LOWEST,
    highest: float = HIGHEST,
    slope: float = -0.5,
) -> Array:
    """Return a sum of sines over a band, at most 1, the slower the greater."""
    hertz = np.geomspace(lowest, highest, WAVES) * rng.uniform(0.9, 1.1, WAVES)
    size = hertz**slope
    phase = rng.uniform(0.0, 2.0 * math.pi, WAVES)
    whole = np.sin(2.0 * math.pi * hertz * time[:, None] + phase) @ size
    return np.asarray(whole / np.abs(whole).max() * _begun(time)[:, 0])


def _begun(time: Array) -> Array:
    """Return what lets a command grow from none within a second, shape (samples, 1)."""
    return np.minimum(time, 1.0)[:, None]
