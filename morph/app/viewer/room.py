"""The room that a body takes while it moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.app.viewer.content import Actor
from morph.arrays import Array, Integers

LOOKED_AT = 60
"""Pictures of a motion from which the room that it takes is measured."""

POINT = 0.05
"""m around a link, where a body has no shape at all."""


@dataclass(frozen=True, kw_only=True)
class Room:
    """A body's upright box in some pictures, in its own world."""

    low: Array
    """Least corner, m, shape (pictures, 3)."""
    high: Array
    """Greatest corner, m, shape (pictures, 3)."""
    gone: Array
    """How far its first link has gone along the ground, m, shape (pictures, 2)."""

    @property
    def size(self) -> float:
        """The diagonal of the box in the first picture, m; never 0."""
        return float(np.linalg.norm(self.high[0] - self.low[0])) or 1.0

    def travels(self, times: float) -> bool:
        """Return whether it reaches so many times its own size along x."""
        return bool(self.high[:, 0].max() - self.low[:, 0].min() > times * self.size)


def looked_at(actors: Sequence[Actor]) -> Integers:
    """Return the pictures from which room is measured, the same for all actors."""
    last = max((actor.motion.pictures for actor in actors), default=1) - 1
    return np.unique(np.linspace(0, last, LOOKED_AT).round().astype(np.int64))


def room(actor: Actor, pictures: Integers) -> Room:
    """Return the room that an actor takes in some pictures.

    Shapes that are fixed to the world count, as a rail does; a floor has no end and does not.
    """
    motion = actor.motion
    which = np.minimum(pictures, motion.pictures - 1)
    low = np.full((len(which), 3), np.inf)
    high = np.full((len(which), 3), -np.inf)
    tight = np.array([low[0], high[0]])
    for shape in actor.figure.shapes:
        least, most = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        turn = matrices(motion.turn[which, shape.body])
        centre = motion.position[which, shape.body] + turn @ (0.5 * (least + most))
        half = np.abs(turn) @ (0.5 * (most - least))
        low, high = np.minimum(low, centre - half), np.maximum(high, centre + half)
        # The first picture is framed and labelled, so that its box must be tight.
        corners = shape.vertices @ turn[0].T + motion.position[which[0], shape.body]
        tight[0] = np.minimum(tight[0], corners.min(axis=0))
        tight[1] = np.maximum(tight[1], corners.max(axis=0))
    low[0], high[0] = tight
    if not actor.figure.shapes:
        low = motion.position[which].min(axis=1) - POINT
        high = motion.position[which].max(axis=1) + POINT
    return Room(low=low, high=high, gone=gone(actor)[which])


def gone(actor: Actor) -> Array:
    """Return how far an actor has gone along the ground in each picture, m, shape (pictures, 2).

    It is what its first link has gone: the trunk of a walker, the cart of a pole.
    """
    position = actor.motion.position
    first = position[:, min(1, position.shape[1] - 1), :2]
    return np.asarray(first - first[0])


def matrices(turn: Array) -> Array:
    """Return the rotation matrices of unit quaternions, w first: (..., 4) to (..., 3, 3)."""
    w, x, y, z = np.moveaxis(turn, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
