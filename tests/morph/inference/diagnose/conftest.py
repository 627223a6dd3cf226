"""Recordings of a pendulum whose motion is a few lines of arithmetic: nothing here is MuJoCo's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from morph.arrays import Array
from morph.record.recording import Channel, Recording

STEP = 5e-4
RATE = 100.0
EVERY = round(1.0 / (RATE * STEP))
"""Steps between readings."""
NOISE = 3e-4
"""Standard deviation of a reading, rad."""


def swing(
    q: Array, v: Array, torque: Array, *, mass: float = 1.0, friction: float = 0.0,
    force: Callable[[Array, Array], Array] | None = None,
) -> Array:  # fmt: skip
    """Return positions and velocities at each reading of pendulums as `robots/pendulum` has one.

    Moreau's midpoint rule: half a drift, the velocity extrapolated to there, dry friction as an
    impulse that can stop, half a drift.

    Args:
        q: Positions at the start, rad; 0 hangs down.
        v: Velocities at the start, rad/s.
        torque: The motor's torque over each step, N m, shape (steps, ...).
        mass: Of the ball, kg.
        friction: Level of dry friction, N m.
        force: From positions and velocities to one more torque, N m.
    """
    inertia, weight = 0.001 + mass * 0.5**2, mass * 9.81 * 0.5
    before, path = v, [(q, v)]
    for effort in torque:
        middle, speed = q + 0.5 * STEP * v, 1.5 * v - 0.5 * before
        pull = effort - weight * np.sin(middle) + (force(middle, speed) if force else 0.0)
        free = v + STEP * pull / inertia
        before, v = v, np.sign(free) * np.maximum(np.abs(free) - STEP * friction / inertia, 0.0)
        q = middle + 0.5 * STEP * v
        path.append((q, v))
    return np.array(path[::EVERY])


@dataclass(frozen=True, kw_only=True)
class Truth:
    """Runs of one pendulum, as they were and as they were read."""

    path: Array
    """True positions and velocities at each reading, shape (readings, 2, runs)."""
    recordings: list[Recording]
    """What was read and commanded."""

    def described(self, run: int, first: int, count: int) -> Array:
        """Return where the described pendulum is at the readings after a true state of a run."""
        told = self.recordings[run]["hinge.command"][first : first + count]
        return swing(*self.path[first, :, run], np.repeat(told, EVERY))[1:, 0]


def record(
    *, seeds: Sequence[int], seconds: float = 4.0, gain: float = 1.0,
    push: Sequence[Callable[[Array], Array]] = (), **true: Any,
) -> Truth:  # fmt: skip
    """Return runs of a pendulum that is not as described, one a seed.

    Args:
        seeds: Of commands, starts and noise.
        seconds: Length of each run.
        gain: Torque over command.
        push: For each run, from times, s, to a torque that is in no recording.
        true: What else is not as described; see `swing`.
    """
    ticks = np.arange(round(seconds * RATE) + 1) / RATE
    commands, starts = [], []
    for rng in map(np.random.default_rng, seeds):
        # Six sines from 0.2 to 3 Hz that rise within half a second.
        rate, phase = np.exp(rng.uniform(*np.log([0.2, 3.0]), 6)), rng.uniform(0, 2 * np.pi, 6)
        wave = np.sin(2 * np.pi * ticks[:, None] * rate + phase).sum(axis=1)
        commands.append((3.0 * wave / np.abs(wave).max() * np.clip(2 * ticks, 0, 1)).round(6))
        starts.append(rng.uniform(-0.7, 0.7))
    torque = gain * np.repeat(np.array(commands).T[:-1], EVERY, axis=0)
    for row, pushed in enumerate(push):
        torque[:, row] += pushed((np.arange(len(torque)) + 0.5) * STEP)
    path = swing(np.array(starts), np.zeros(len(starts)), torque, **true)
    recordings = []
    for row, seed in enumerate(seeds):
        noise = np.random.default_rng([seed, 1]).normal(0.0, NOISE, len(ticks))
        told = Channel(time=ticks, value=commands[row], hold=True)
        read = Channel(time=ticks, value=path[:, 0, row] + noise)
        channels = {"hinge.position": read, "hinge.command": told}
        recordings.append(Recording(name=f"run_{seed}", channels=channels))
    return Truth(path=path, recordings=recordings)


@pytest.fixture(scope="session")
def recorded() -> Callable[..., Truth]:
    """Makes runs; see `record`."""
    return record
