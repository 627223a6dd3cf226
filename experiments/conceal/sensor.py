"""What a logger reads: encoders with noise and steps."""

from __future__ import annotations

import numpy as np

from experiments.conceal.equations import Array, Equations

FINEST = 16384
"""Counts per turn of the finest encoder; a slide then counts in 0.1 mm."""


def quanta(equations: Equations, counts: float) -> Array:
    """Return an encoder's step for each joint, rad or m, shape (joints,)."""
    fine = [2 * np.pi / FINEST if kind == "hinge" else 1e-4 for kind in equations.kinds]
    return np.array(fine) * (FINEST / counts)


def noise_rms(quantum: Array) -> Array:
    """Return the RMS error of a reading: Gaussian noise of one step, and rounding.

    Rounding adds step^2 / 12 to the variance.
    """
    return np.asarray(quantum * np.sqrt(1 + 1 / 12))


def read(position: Array, quantum: float, rng: np.random.Generator) -> Array:
    """Return positions as the encoder reports them."""
    noisy = position + quantum * rng.standard_normal(position.shape)
    return np.asarray(np.round(noisy / quantum) * quantum)
