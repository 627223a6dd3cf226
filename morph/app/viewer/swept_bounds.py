"""Bounding box that a body sweeps during a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.content import Actor
from morph.app.viewer.motion import MotionFrames
from morph.arrays import Array, Integers

LOOKED_AT = 60
"""Pictures of a motion from which the room that it takes is measured."""

POINT = 0.05
"""m around a link, where a body has no shape at all."""

EIGHT: Integers = np.array(list(product((0, 1), repeat=3)))
"""Which end of each axis the corners of a box are at."""


@dataclass(frozen=True, kw_only=True)
class SweptBounds:
    """A body's upright box in some pictures, in its own world."""

    low: Array
    """Least corner, m, shape (pictures, 3)."""
    high: Array
    """Greatest corner, m, shape (pictures, 3)."""
    gone: Array
    """How far its first link has gone along the ground, m, shape (pictures, 2)."""
    rise: Array
    """How much higher its top is than in the first picture, about, m, shape (pictures,)."""
    corners: Array
    """Corners of its shapes' boxes, m, shape (pictures, corners, 3)."""
    core: Array
    """Corners of the upright box of its links in the first picture, without what is fixed to
    the world, m, shape (2, 3)."""
    fixed: int
    """How many of the corners, the first, are of what is fixed to the world, as a rail is."""

    @property
    def size(self) -> float:
        """The diagonal of the box of its links in the first picture, m; never 0."""
        return float(np.linalg.norm(self.core[1] - self.core[0])) or 1.0


def looked_at(actors: Sequence[Actor]) -> Integers:
    """Return the pictures from which room is measured, the same for all actors."""
    last = max((actor.motion.pictures for actor in actors), default=1) - 1
    return np.unique(np.linspace(0, last, LOOKED_AT).round().astype(np.int64))


def room(actor: Actor, pictures: Integers) -> SweptBounds:
    """Return the room that an actor takes in some pictures.

    Shapes that are fixed to the world count, as a rail does; a floor has no end and does not.
    """
    motion = actor.motion
    which = np.minimum(pictures, motion.pictures - 1)
    shapes = sorted(actor.figure.shapes, key=lambda shape: shape.body > 0)
    corners = [_corners(shape, motion, which) for shape in shapes]
    if not corners:
        corners = [motion.position[which] - POINT, motion.position[which] + POINT]
    points = np.concatenate(corners, axis=1)
    low, high = points.min(axis=1), points.max(axis=1)
    rise = high[:, 2] - high[0, 2]
    core = np.array([low[0], high[0]])
    if actor.figure.shapes:
        # The first picture is framed and labelled, so that its box must be tight.
        tight = [_tight(shape, motion, int(which[0])) for shape in actor.figure.shapes]
        low[0], high[0] = np.min(tight, axis=0)[0], np.max(tight, axis=0)[1]
        links = [box for box, shape in zip(tight, actor.figure.shapes, strict=True) if shape.body]
        core = np.array([np.min(links or tight, axis=0)[0], np.max(links or tight, axis=0)[1]])
    return SweptBounds(
        low=low,
        high=high,
        gone=gone(actor)[which],
        rise=rise,
        corners=points,
        core=core,
        fixed=len(EIGHT) * sum(shape.body == 0 for shape in shapes),
    )


def _corners(shape: PictureShape, motion: MotionFrames, which: Integers) -> Array:
    """Return the corners of a shape's box in some pictures, m, shape (pictures, 8, 3)."""
    least, most = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    box = np.stack((least, most))[EIGHT, np.arange(3)]
    turn = matrices(motion.turn[which, shape.body])
    return np.asarray(box @ np.swapaxes(turn, -1, -2) + motion.position[which, None, shape.body])


def _tight(shape: PictureShape, motion: MotionFrames, picture: int) -> Array:
    """Return the corners of a shape's upright box in one picture, m, shape (2, 3)."""
    turn = matrices(motion.turn[picture, shape.body])
    corners = shape.vertices @ turn.T + motion.position[picture, shape.body]
    return np.array([corners.min(axis=0), corners.max(axis=0)])


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
