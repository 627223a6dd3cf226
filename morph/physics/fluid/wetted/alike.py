"""Shapes told apart by form alone: where they lie, and which way they are mirrored, set aside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh

DIGITS = 36
"""Binary digits that a coordinate keeps: a part in 7e10 of the whole."""

EVEN = 1e-6
"""Skew along an axis, as a part of its spread, below which shapes are their own mirror image."""


@dataclass(frozen=True, kw_only=True)
class Form:
    """Shapes about their middle, and how they came to lie so: there = signs * here + middle."""

    shapes: tuple[Mesh, ...]
    """The same for all shapes that differ by place and by mirroring alone, m."""
    middle: Array
    """Where their middle was, shape (3,), m."""
    signs: Array
    """-1 along each axis that was mirrored, shape (3,)."""

    @property
    def content(self) -> tuple[bytes, ...]:
        """All that they are, for a key."""
        return tuple(
            part for one in self.shapes for part in (one.vertices.tobytes(), one.faces.tobytes())
        )


def form_of(shapes: tuple[Mesh, ...]) -> Form:
    """Return shapes about their middle, mirrored so that each axis skews forward.

    Coordinates are rounded to a power of two far below what matters, so that six
    paddles with their last digits apart are one paddle.
    """
    points = np.concatenate([shape.vertices[shape.faces].reshape(-1, 3) for shape in shapes])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    step = 2.0 ** (np.round(np.log2(np.linalg.norm(high - low))) - DIGITS)
    away = points - middle
    skew = (away**3).sum(axis=0)
    signs = np.where(skew < -EVEN * (np.abs(away) ** 3).sum(axis=0), -1.0, 1.0)
    turned = [_ordered(shape, middle, signs, float(step)) for shape in shapes]
    return Form(
        shapes=tuple(sorted(turned, key=lambda one: (len(one.faces), one.vertices.tobytes()))),
        middle=middle,
        signs=signs,
    )


def _ordered(shape: Mesh, middle: Array, signs: Array, step: float) -> Mesh:
    """Return a shape with its corners and faces in an order that follows from their places."""
    corners = np.rint(signs * (shape.vertices - middle) / step)
    used, faces = np.unique(shape.faces, return_inverse=True)
    order = np.lexsort(corners[used].T)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    faces = rank[faces.reshape(-1, 3)]
    if signs.prod() < 0.0:
        faces = faces[:, ::-1]
    # Adding 0 turns -0 into 0.
    return Mesh(vertices=step * corners[used][order] + 0.0, faces=_sorted(faces))


def _sorted(faces: Integers) -> Integers:
    first = faces.argmin(axis=1)
    rolled = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)
    result: Integers = np.ascontiguousarray(rolled[np.lexsort(rolled.T[::-1])])
    return result
