"""States as numbers to learn from: angles by sine and cosine, differences the shorter way round."""

from __future__ import annotations

import math

import numpy as np

from morph.alignment.arrays import Array, Mask


def features(x: Array, turns: Mask) -> Array:
    """Return what does not turn, then of each angle its sine and its cosine.

    Args:
        x: States, shape (..., n).
        turns: Which numbers are angles, rad, that may go round, shape (n,).
    """
    angle = x[..., turns]
    round_about = np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    return np.concatenate([x[..., ~turns], round_about.reshape(*angle.shape[:-1], -1)], axis=-1)


def change(x: Array, after: Array, turns: Mask) -> Array:
    """Return after - x, angles taken the shorter way round; shape (..., n)."""
    move = np.asarray(after - x)
    move[..., turns] -= 2.0 * math.pi * np.round(move[..., turns] / (2.0 * math.pi))
    return move
