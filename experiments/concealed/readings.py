"""From motion to readings: what sensors show, and what the logger writes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.concealed.excite import Logger
from experiments.concealed.plant import Array, Plant
from experiments.concealed.simulate import GRID, Motion, Run

DIGITS = 8
"""Decimals of readings in files."""


def ideal_readings(plant: Plant, q: Array, ticks: Array, step: float, joints: int) -> Array:
    """Return what sensors without noise and rounding show, shape (ticks, joints).

    Args:
        plant: The plant, whose sensors may be late, scaled or off.
        q: Positions at every step, shape (steps + 1, n).
        ticks: Multiples of `GRID`.
        step: Step, s.
        joints: How many joints have a sensor, the first ones.
    """
    out = np.zeros((len(ticks), joints))
    for i in range(joints):
        place = np.maximum(ticks * GRID - plant.of_joint("shift")[i], 0.0) / step
        below = np.minimum(place.astype(int), len(q) - 2)
        x = q[below, i] + (place - below) * (q[below + 1, i] - q[below, i])
        x = x + plant.of_joint("tooth")[i] * np.sin(plant.of_joint("tooth_n")[i] * x)
        out[:, i] = plant.of_joint("scale")[i] * x + plant.of_joint("bias")[i]
    return out


@dataclass(frozen=True, kw_only=True)
class Log:
    """The rows that a logger wrote of one run."""

    kept: Array
    """Indices of the ticks that were not lost."""
    time: Array
    """Written times, s."""
    position: Array
    """Position readings, shape (rows, joints)."""
    velocity: Array | None
    """Velocity readings, same shape, or None where there are none."""
    command: Array
    """Commands, same shape."""


def write_down(
    run: Run, motion: Motion, logger: Logger, rng: np.random.Generator, joints: int, drift: float
) -> Log:
    """Return what the logger wrote of a run.

    Args:
        run: The run.
        motion: What happened in it.
        logger: The logger.
        rng: Source of chance.
        joints: How many joints the description has.
        drift: How much too fast its clock runs, as a share.
    """
    ticks = run.ticks
    stamp = ticks * GRID * (1 + drift) + logger.stamp_error * rng.standard_normal(len(ticks))
    least = 0.1 / logger.rate_hz
    stamp = np.maximum.accumulate(stamp - least * np.arange(len(ticks))) + least * np.arange(
        len(ticks)
    )
    keep = rng.random(len(ticks)) >= logger.loss
    keep[[0, -1]] = True
    kept = np.flatnonzero(keep)
    velocity = None
    if logger.velocity:
        _, v = motion.at(ticks[kept])
        # As a tachometer of the same quality over 20 ms.
        velocity = v[:, :joints] + logger.noise / 0.02 * rng.standard_normal((len(kept), joints))
    return Log(
        kept=kept,
        time=(stamp - stamp[0])[kept].round(6),
        position=motion.reading[kept, :joints].round(DIGITS),
        velocity=velocity,
        command=motion.command[kept, :joints],
    )
