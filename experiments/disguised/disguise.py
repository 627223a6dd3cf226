"""Hidden maps: numbers permuted, flipped, scaled, doubled, mixed and bent."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array

LEAST_BEND, MOST_BEND = 0.2, 0.4
"""How far the slope of a bent number departs from 1."""

SCALES = (0.3, 3.0)
"""Least and greatest factor of a number of the disguise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bend:
    """y = factor * (z + b sin(z + p) - b sin p), z = M x / spread: monotone in z for b < 1."""

    mix: Array
    """M: a signed permutation, and below it rows that repeat or mix, shape (m, n)."""
    spread: Array
    """Of x, shape (n,)."""
    bend: Array
    """b, shape (m,); 0 is straight."""
    phase: Array
    """p, rad, shape (m,)."""
    factor: Array
    """Positive, shape (m,)."""

    def worn(self, x: Array) -> Array:
        """Return what x (..., n) looks like, shape (..., m)."""
        return self.bent((x / self.spread) @ self.mix.T)

    def bent(self, z: Array) -> Array:
        """Return y of z, shape (..., m) both."""
        waves = np.sin(z + self.phase) - np.sin(self.phase)
        return np.asarray(self.factor * (z + self.bend * waves))

    def bared(self, y: Array) -> Array:
        """Return z of y, by bisection; shape (..., m)."""
        straight = np.asarray(y / self.factor)
        low, high = straight - 2.0, straight + 2.0
        for _ in range(60):
            z = 0.5 * (low + high)
            less = z + self.bend * (np.sin(z + self.phase) - np.sin(self.phase)) < straight
            low, high = np.where(less, z, low), np.where(less, high, z)
        return np.asarray(0.5 * (low + high))


@dataclass(frozen=True, kw_only=True, eq=False)
class Disguise:
    """How a body's states look, and which of its commands a told command amounts to."""

    states: Bend
    """y = states.worn(x)."""
    commands: Bend
    """z = commands.bared(a), of which u = spread * (pinv(M) z) is what the body is told."""
    redundant: bool
    """Whether there are more numbers than the body has."""
    bent: bool
    """Whether numbers are bent."""

    def command(self, told: Array) -> Array:
        """Return the body's commands u (..., k) of the disguise's a (..., k_t)."""
        load = np.linalg.pinv(self.commands.mix)
        return np.asarray(self.commands.bared(told) @ load.T * self.commands.spread)


def disguise(
    spread: Array, command: Array, rng: np.random.Generator, *, redundant: bool, bent: bool
) -> Disguise:
    """Return a disguise by chance.

    Args:
        spread: Of the body's states, shape (n,).
        command: Of its commands, shape (k,).
        rng: The chance of it.
        redundant: Add two numbers to the states, one that repeats and one that mixes two, and one
            to the commands, which shares the load of another.
        bent: Bend every number.
    """
    return Disguise(
        states=_bend(spread, rng, more=2 if redundant else 0, bent=bent),
        commands=_bend(command, rng, more=1 if redundant else 0, bent=bent),
        redundant=redundant,
        bent=bent,
    )


def _bend(spread: Array, rng: np.random.Generator, *, more: int, bent: bool) -> Bend:
    n = len(spread)
    mix = np.eye(n)[rng.permutation(n)] * rng.choice([-1.0, 1.0], size=(n, 1))
    for extra in range(more):
        row = np.zeros(n)
        chosen = rng.choice(n, size=min(n, extra + 1), replace=False)
        row[chosen] = rng.choice([-1.0, 1.0], size=len(chosen)) / np.sqrt(len(chosen))
        mix = np.concatenate([mix, row[None]])
    m = n + more
    mix = mix[rng.permutation(m)]
    size = rng.uniform(LEAST_BEND, MOST_BEND, size=m) if bent else np.zeros(m)
    return Bend(
        mix=mix,
        spread=spread,
        bend=size,
        phase=rng.uniform(0.0, 2.0 * np.pi, size=m),
        factor=np.exp(rng.uniform(math.log(SCALES[0]), math.log(SCALES[1]), size=m)),
    )
