"""Visibility of bodies from the camera."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from morph.arrays import Array

HIDDEN = 0.95
"""Part of a body's size in the picture that is lost where others hide all of it."""

MATTERS = 3.0
"""How many times more it matters than distance does: one may come nearer, not look through."""

WAYS = 96
"""Directions in which the outline of what must be seen is kept."""


def sight(cores: Array, place: Array, lanes: Sequence[int], label: Array, letters: Array) -> float:
    """Return how large bodies are seen, as the mean of the logarithm of the angle of each.

    One that another hides, or another's name, is seen as so much smaller.

    Args:
        cores: Corners of each body's upright box, m, shape (bodies, 2, 3).
        place: Where the camera is, m, shape (3,).
        lanes: The lane of each body; those of one hide each other as they are meant to.
        label: How high names are, and how wide a letter is, rad, shape (2,).
        letters: How many letters each name has, shape (bodies,).
    """
    far = np.linalg.norm(cores.mean(axis=1) - place, axis=1)
    low, high = _pictured(cores - place)
    size = np.linalg.norm(high - low, axis=1)
    own = np.prod(high - low, axis=1)
    # A body hides with its name above it what is behind.
    middle, half = 0.5 * (low[:, 0] + high[:, 0]), 0.5 * label[1] * letters
    named = np.maximum(high[:, 0], middle + half), high[:, 1] + label[0] * (letters > 0)
    most = np.stack(named, axis=1)
    least = np.stack((np.minimum(low[:, 0], middle - half), low[:, 1]), axis=1)
    hidden = np.zeros(len(lanes))
    for at, lane in enumerate(lanes):
        for other, its in enumerate(lanes):
            if its != lane and far[other] < far[at]:
                both = np.minimum(most[at], most[other]) - np.maximum(least[at], least[other])
                hidden[at] += float(np.prod(np.maximum(both, 0.0))) / max(float(own[at]), 1e-12)
    left = np.log(1.0 - HIDDEN * np.minimum(hidden, 1.0))
    return float((np.log(np.maximum(size, 1e-9)) + MATTERS * left).mean())


def outline(points: Array) -> Array:
    """Return the points that reach farthest in some directions, m, shape (at most `WAYS`, 3)."""
    return np.asarray(points[np.unique((points @ _ways().T).argmax(axis=0))])


def _ways() -> Array:
    """Return unit vectors all around, the three axes among them, shape (`WAYS`, 3).

    They lie on a spiral whose turns are the golden angle, as seeds do in a sunflower.
    """
    axes = np.concatenate((np.eye(3), -np.eye(3)))
    count = np.arange(WAYS - len(axes)) + 0.5
    up = 1.0 - 2.0 * count / len(count)
    turn = np.pi * (3.0 - np.sqrt(5.0)) * count
    flat = np.sqrt(1.0 - up**2)
    spiral = np.stack((flat * np.cos(turn), flat * np.sin(turn), up), axis=1)
    return np.concatenate((axes, spiral))


def _pictured(boxes: Array) -> tuple[Array, Array]:
    """Return the corners, about, of boxes as a camera at 0 pictures them: azimuth, elevation.

    Azimuths are measured from the middle of all boxes, so that none leaps by a turn.
    """
    eight = np.array(list(product((0, 1), repeat=3)))
    corners = boxes[:, eight, np.arange(3)]
    middle = boxes.mean(axis=(0, 1))
    turn = np.arctan2(middle[1], middle[0])
    x, y, z = np.moveaxis(corners, -1, 0)
    along = x * np.cos(turn) + y * np.sin(turn)
    angles = np.stack(
        (np.arctan2(y * np.cos(turn) - x * np.sin(turn), along), np.arctan2(z, np.hypot(x, y))),
        axis=-1,
    )
    return angles.min(axis=1), angles.max(axis=1)
