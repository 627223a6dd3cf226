"""What a sensible experimenter commands: multisines, pulses with rests, slow ramps, releases."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.conceal.equations import Array, Equations
from experiments.conceal.laws import neutral
from experiments.conceal.march import Drive, march

SECONDS = 8.0
LIMIT = 9.5
"""Largest command, N m or N: every motor on this shelf saturates at 10."""
KINDS = ("multisine", "pulses", "ramps", "release", "multisine")


@dataclass(frozen=True, kw_only=True)
class Episode:
    """One run as it was planned."""

    ticks: Array
    """When the logger writes a sample and sends a command, s, shape (ticks,)."""
    commands: Array
    """What it sends, shape (joints, ticks)."""
    start: Array
    """Positions from which it starts at rest, shape (joints,)."""
    aim: float
    """Largest excursion wanted, as a share of what an experimenter would allow."""


def clock(rng: np.random.Generator, rate: float) -> Array:
    """Return a logger's ticks, s: periods jitter by 5 % and one in 500 is doubled."""
    count = int(SECONDS * rate * 1.3)
    period = (1 + 0.05 * rng.standard_normal(count).clip(-3, 3)) / rate
    period[rng.random(count) < 0.002] *= 2
    ticks = np.append(0.0, np.cumsum(period)).round(6)
    return np.asarray(ticks[ticks <= SECONDS])


def plan(equations: Equations, rng: np.random.Generator, rate: float) -> list[Episode]:
    """Return the episodes of one case; their amplitudes are still to be scaled."""
    episodes = []
    for kind in KINDS:
        ticks = clock(rng, rate)
        commands = np.zeros((len(equations.joints), len(ticks)))
        start = np.zeros(len(equations.joints))
        for joint, name in enumerate(equations.joints):
            reach = equations.reach[joint]
            if kind == "release" and equations.kinds[joint] == "hinge":
                start[joint] = reach.span * rng.uniform(0.4, 0.9) * rng.choice([-1, 1])
            if name in equations.actuators:
                rail = equations.kinds[joint] == "slide"
                shape = on_rail(kind, ticks, rng) if rail else free(kind, ticks, rng)
                commands[joint] = reach.effort * rng.uniform(0.5, 1.0) * shape
        aim = float(rng.uniform(0.6, 1.0))
        episodes.append(Episode(ticks=ticks, commands=commands, start=start, aim=aim))
    return episodes


def free(kind: str, ticks: Array, rng: np.random.Generator) -> Array:
    """Return a command of size about 1 for a joint that gravity brings back."""
    if kind == "ramps":
        knots = np.array([0.0, 0.5, 2.5, 5.0, 6.5, SECONDS])
        side = float(rng.choice([-1, 1]))
        values = side * np.array([0.0, 0.0, 1.0, -rng.uniform(0.5, 1.0), 0.0, 0.0])
        return np.interp(ticks, knots, values)
    if kind == "pulses":
        return pulses(ticks, rng)
    wave = multisine(ticks, rng, low=0.2, high=3.0) * np.clip(ticks / 0.5, 0, 1)
    if kind == "release":
        wave = wave * np.clip((ticks - 4.0) / 0.5, 0, 1)
    return np.asarray(wave)


def on_rail(kind: str, ticks: Array, rng: np.random.Generator) -> Array:
    """Return a force of size about 1 that brings a cart about back to where it was.

    Nothing pulls a cart back, so the force is the second derivative of a path
    that ends where it began, or pulses in pairs that cancel.
    """
    if kind == "pulses":
        return doublets(ticks, rng)
    fine = np.arange(0.0, SECONDS + 0.01, 0.01)
    low, high = (0.08, 0.25) if kind == "ramps" else (0.2, 1.5)
    path = multisine(fine, rng, low=low, high=high)
    path *= np.sin(np.pi * np.clip(fine, 0, 1) / 2) ** 4
    if kind == "release":
        path *= np.sin(np.pi * np.clip(fine - 4, 0, 1) / 2) ** 4
    force = np.gradient(np.gradient(path, fine), fine)
    force[0] = 0.0
    return np.asarray(np.interp(ticks, fine, force / np.abs(force).max()))


def multisine(times: Array, rng: np.random.Generator, *, low: float, high: float) -> Array:
    """Return six sines at random frequencies, Hz, with random phases; greatest value 1."""
    frequency = np.exp(rng.uniform(np.log(low), np.log(high), 6))
    phase = rng.uniform(0, 2 * np.pi, 6)
    wave = np.sin(2 * np.pi * times[:, None] * frequency + phase).sum(axis=1)
    return np.asarray(wave / np.abs(wave).max())


def pulses(ticks: Array, rng: np.random.Generator) -> Array:
    """Return steps of random height and length with rests between them."""
    out, now = np.zeros_like(ticks), float(rng.uniform(0.3, 0.6))
    while now < SECONDS:
        length = rng.uniform(0.2, 0.8)
        height = rng.uniform(0.4, 1.0) * rng.choice([-1, 1])
        out[(ticks >= now) & (ticks < now + length)] = height
        now += length + rng.uniform(0.5, 1.2)
    return out


def doublets(ticks: Array, rng: np.random.Generator) -> Array:
    """Return pulses in pairs, there and back, with rests between them."""
    out, now, side = np.zeros_like(ticks), float(rng.uniform(0.3, 0.6)), 1.0
    while now < SECONDS:
        length, rest = rng.uniform(0.2, 0.5), rng.uniform(0.4, 1.0)
        height = rng.uniform(0.4, 1.0)
        for way in (1.0, -1.0):
            out[(ticks >= now) & (ticks < now + length)] = way * side * height
            out[(ticks >= now + length) & (ticks < now + 2 * length)] = -way * side * height
            now += 2 * length + rest
        side = -side
    return out


def scaled(equations: Equations, episodes: list[Episode]) -> list[Episode]:
    """Return the episodes with commands that reach what each aims at.

    As an experimenter would, by trying amplitudes; here on the nominal mechanism.
    Commands end rounded to 1e-6, as they are written to a file.
    """
    joints, rows = len(equations.joints), len(episodes)
    parameters = {k: np.full(rows, x) for k, x in equations.nominal().items()}
    laws = neutral(joints, rows)
    drive = Drive(
        ticks=tuple(e.ticks for e in episodes), commands=tuple(e.commands for e in episodes)
    )
    step = 1e-3
    torque = drive.produced(laws, np.zeros(rows), round(SECONDS / step), step)
    start = np.array([e.start for e in episodes]).T
    span = np.array([reach.span for reach in equations.reach])[:, None]
    aim = np.array([e.aim for e in episodes])
    most = LIMIT / np.array([max(np.abs(e.commands).max(), 1e-9) for e in episodes])
    scale, best, closest = np.ones(rows), np.ones(rows), np.full(rows, np.inf)
    for _ in range(6):
        motion = march(
            equations, parameters, laws, torque * scale, start, np.zeros_like(start), step=step
        )
        ratio = (np.abs(motion.q).max(axis=0) / span).max(axis=0) / aim
        better = np.abs(np.log(ratio)) < closest
        closest = np.where(better, np.abs(np.log(ratio)), closest)
        best = np.where(better, scale, best)
        scale = np.clip(scale * ratio**-0.8, 0.05, most)
    return [
        replace(e, commands=(e.commands * s).round(6)) for e, s in zip(episodes, best, strict=True)
    ]
