"""From motion to readings: what sensors show, and what the logger writes of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.concealed.excite import Logger
from experiments.concealed.mjcf import quaternion
from experiments.concealed.plant import Array, Plant
from experiments.concealed.simulate import GRID, Motion, Run

DIGITS = 8
"""Decimals of readings in files."""
POSE = (*(f"position.{axis}" for axis in "xyz"), *(f"orientation.{axis}" for axis in "wxyz"))
"""Channels of a link that a camera tracks."""
ARM = 0.3
"""Length at whose end a camera knows a place as well as it knows an orientation, m."""


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


def link_poses(plant: Plant, q: Array) -> tuple[Array, Array]:
    """Return where links are and how they are turned, (samples, n, 3) and (samples, n, 3, 3).

    Args:
        plant: The plant.
        q: Positions of its first n joints, shape (samples, n).
    """
    samples, n = q.shape
    place, turn = np.zeros((samples, n, 3)), np.empty((samples, n, 3, 3))
    for i in range(n):
        before = int(plant.parent[i])
        rooted = before < 0
        root = np.broadcast_to(np.eye(3), (samples, 3, 3)) if rooted else turn[:, before]
        still = root @ plant.rotation[i]
        place[:, i] = root @ plant.origin[i] + (0.0 if rooted else place[:, before])
        x, y, z = plant.axis[i]
        if plant.slide[i]:
            place[:, i] += q[:, i, None] * (still @ plant.axis[i])
            turn[:, i] = still
            continue
        # Rodrigues' formula.
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        sine, cosine = np.sin(q[:, i, None, None]), np.cos(q[:, i, None, None])
        turn[:, i] = still @ (np.eye(3) + sine * cross + (1.0 - cosine) * cross @ cross)
    return place, turn


def seen_by_camera(poses: tuple[Array, Array], logger: Logger, rng: np.random.Generator) -> Array:
    """Return noisy places and unit quaternions of links, shape (samples, 7 links).

    A camera knows an orientation as well as the usual encoder of this logger knows its joint,
    and a place as well as that does at the end of an arm of `ARM`.
    """
    place, turn = poses
    usual = float(np.median(logger.noise))
    place = place + ARM * usual * rng.standard_normal(place.shape)
    # A quaternion's imaginary part is half a small rotation.
    turns = np.array([[quaternion(each) for each in row] for row in turn])
    turns += 0.5 * usual * rng.standard_normal(turns.shape)
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    return np.concatenate([place, turns], axis=-1).reshape(len(place), -1).round(DIGITS)


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
