"""What an experimenter commands: slow and fast multisines, steps with rests, drives cut off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.concealed.mechanism import SERVO, TORQUE, Mechanism
from experiments.concealed.plant import Array
from experiments.concealed.simulate import GRID, Run

FINE = 1e-3
"""Spacing at which paths are drawn, s."""
KINDS = ("multisine", "steps", "fast", "slow")
"""Kinds of the training runs; the held-out run is a multisine of its own."""


@dataclass(frozen=True, kw_only=True)
class Logger:
    """How a case's logger works."""

    rate_hz: float
    """Ticks per second."""
    jitter: float
    """Standard deviation of periods, as a share of the period."""
    stamp_error: float
    """Standard deviation of written times, s."""
    loss: float
    """Share of the rows that are lost."""
    velocity: bool
    """Whether velocities are logged too."""
    noise: Array
    """Standard deviation of each position reading before rounding, shape (joints,)."""
    count: Array
    """Resolution of each encoder, 0 where it is finer than the file, shape (joints,)."""

    @property
    def error(self) -> Array:
        """RMS error of each reading: noise, and rounding with variance count^2 / 12."""
        return np.asarray(np.sqrt(self.noise**2 + self.count**2 / 12))


def draw_logger(mechanism: Mechanism, rng: np.random.Generator, *, quiet: bool) -> Logger:
    """Return a logger from 50 to 500 Hz, with sensors from quiet to bad, or with quiet ones."""
    slide = mechanism.plant.slide == 1
    loudest = 1e-4 if quiet else 2e-3
    noise = np.exp(rng.uniform(np.log(3e-5), np.log(loudest))) * np.where(slide, 0.3, 1.0)
    rate = float(np.round(np.exp(rng.uniform(np.log(50), np.log(500)))))
    return Logger(
        rate_hz=rate,
        jitter=float(rng.uniform(0.0, 0.1)),
        stamp_error=float(rng.choice([0.0, rng.uniform(0.0, 0.02) / rate])),
        loss=float(rng.choice([0.0, rng.uniform(0.0, 0.01)])),
        velocity=bool(rng.random() < 0.3),
        noise=noise * np.exp(rng.uniform(-0.3, 0.3, len(slide))),
        count=noise * float(rng.choice([0.0, rng.uniform(0.5, 3.0)])),
    )


def plan(
    mechanism: Mechanism, logger: Logger, rng: np.random.Generator, seconds: float
) -> tuple[Run, ...]:
    """Return the runs of a case, the held-out one last."""
    return tuple(_plan_run(mechanism, logger, rng, kind, seconds) for kind in (*KINDS, "multisine"))


def _plan_run(
    mechanism: Mechanism, logger: Logger, rng: np.random.Generator, kind: str, seconds: float
) -> Run:
    fine = np.arange(round(seconds / FINE) + 1) * FINE
    n, driven = mechanism.plant.count, mechanism.driven
    path = np.tile(mechanism.home, (len(fine), 1))
    for joint in driven:
        path[:, joint] += mechanism.span[joint] * _shape(kind, fine, mechanism.rate, rng)
    ticks = _ticks(logger, rng, seconds)
    now = ticks * GRID
    reference = np.column_stack([np.interp(now, fine, path[:, i]) for i in range(n)])
    effort = _inverse_dynamics(mechanism, path)
    effort = np.column_stack([np.interp(now, fine, effort[:, i]) for i in range(n)])
    kinds = mechanism.plant.of_joint("drive")
    feed = np.where(kinds == SERVO, reference, np.where(kinds == TORQUE, effort, 0.0))
    if kind == "steps" and mechanism.coasts:
        for begin in rng.uniform(0.2, 0.8, 2) * seconds:
            off = (now >= begin) & (now < begin + 0.08 * seconds)
            feed[off], reference[off] = 0.0, np.nan
    return Run(
        ticks=ticks,
        feed=feed.round(6),
        reference=reference,
        noise=logger.noise * rng.standard_normal(feed.shape),
        start=path[0],
        grids=round(seconds / GRID),
    )


def _inverse_dynamics(mechanism: Mechanism, path: Array) -> Array:
    """Return the effort that the description predicts along a path at spacing `FINE`."""
    plant = mechanism.plant
    v = np.gradient(path, FINE, axis=0)
    a = np.gradient(v, FINE, axis=0)
    mass, bias = plant.mass_and_bias(path, v)
    return np.asarray(
        np.einsum("tij,tj->ti", mass, a)
        + bias
        + plant.of_joint("rotor") * a
        + plant.of_joint("viscous") * v
    )


def _ticks(logger: Logger, rng: np.random.Generator, seconds: float) -> Array:
    period = 1.0 / logger.rate_hz
    gaps = period * (1 + logger.jitter * rng.standard_normal(int(1.3 * seconds / period) + 10))
    grid = np.round(np.append(0.0, np.cumsum(np.maximum(gaps, 0.2 * period))) / GRID).astype(int)
    grid = np.unique(grid)
    return np.asarray(grid[grid <= round(seconds / GRID)])


def _shape(kind: str, time: Array, rate: float, rng: np.random.Generator) -> Array:
    """Return a path of size at most 1 that starts at rest at 0."""
    if kind == "steps":
        return _steps(time, rate, rng)
    low, high, size = {
        "multisine": (0.15, 1.0, rng.uniform(0.6, 1.0)),
        "fast": (0.5, 2.0, rng.uniform(0.25, 0.5)),
        "slow": (0.05, 0.2, rng.uniform(0.8, 1.0)),
    }[kind]
    frequency = rate * np.exp(rng.uniform(np.log(low), np.log(high), 5))
    phase = rng.uniform(0, 2 * np.pi, 5)
    wave = np.sin(2 * np.pi * time[:, None] * frequency + phase).sum(axis=1)
    return np.asarray(size * _smooth(time / 1.0) * wave / np.abs(wave).max())


def _steps(time: Array, rate: float, rng: np.random.Generator) -> Array:
    """Return moves between random positions with rests between them."""
    out, now, here = np.zeros_like(time), 0.3, 0.0
    while now < time[-1]:
        length, there = rng.uniform(0.4, 1.0) / rate, rng.uniform(-1, 1)
        out = np.where(time >= now, here + (there - here) * _smooth((time - now) / length), out)
        now += length + rng.uniform(0.3, 1.0)
        here = there
    return out


def _smooth(share: Array) -> Array:
    """Return the minimum-jerk rise from 0 to 1. Source: Flash and Hogan 1985, eq. 3."""
    x = np.clip(share, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x**2))
