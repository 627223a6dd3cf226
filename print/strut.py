"""What joins separate pieces of a part: straight struts, or bent ones around what is in the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from morph.print.arrays import Array
from morph.print.bend import bent
from morph.print.solid import ball, hull, pieces

DENSE_MM = 3.0
"""Greatest length of an edge where pieces are measured."""

SLIM_MM = 3.0
"""Radius of a strut that takes what room there is."""

THINNEST_MM = 2.2
"""Least radius of a strut, where there is little room."""

MANY = 4000
"""How many patches of that size a large surface is divided into at most, some points each."""

TRIES = 10
"""How many straight struts are tried before a bent one is looked for."""

HELD_MM3 = 1.0
"""How much of a strut is at least in each of the pieces that it joins."""

KEPT = 0.9
"""Part of a straight strut that must be left where nothing may be cut from it."""


def thickness(first: Any, second: Any) -> float:
    """Return the radius of a strut between two pieces, mm: a third of the smaller one's size."""
    volume = min(first.volume(), second.volume())
    return float(np.clip(0.35 * np.cbrt(volume), 3.0, 8.0))


def strut(first: Any, second: Any, forbidden: Any) -> Any | None:
    """Return a solid that joins two pieces and leaves forbidden room empty; None if none does.

    Args:
        first: A solid in one piece.
        second: Another.
        forbidden: Where nothing may be; it may be empty.
    """
    radius = thickness(first, second)
    a, b = points(first), points(second)
    for thin in (radius, max(0.7 * radius, SLIM_MM)):
        result = _straight(first, second, _pairs(a, b, 2.0 * thin), thin, forbidden)
        if result is not None:
            return result
    ways = bent(a, b, forbidden, (radius, max(0.6 * radius, SLIM_MM), THINNEST_MM))
    joined = (_joining(first, second, way) for way in ways)
    return next((way - forbidden for way in joined if way is not None), None)


def _straight(
    first: Any, second: Any, ends: Sequence[tuple[Array, Array]], radius: float, forbidden: Any
) -> Any | None:
    """Return the straight strut of which least is forbidden; None if all lose too much."""
    best: tuple[float, Any] | None = None
    for start, end in ends:
        whole = _between(first, second, start, end, radius)
        joining = _joining(first, second, whole - forbidden)
        if joining is None:
            continue
        left = joining - forbidden
        share = left.volume() / whole.volume()
        if share >= KEPT:
            # One that loses nothing is good; else the one that loses least is taken.
            if share > 0.999:
                return left
            if best is None or share > best[0]:
                best = (share, left)
    return None if best is None else best[1]


def points(solid: Any) -> Array:
    """Return points all over the surface of a solid, shape (n, 3)."""
    apart = max(DENSE_MM, float(np.sqrt(solid.surface_area() / MANY)))
    dense = solid.refine_to_length(apart).to_mesh64().vert_properties
    return np.unique(np.round(np.asarray(dense, dtype=np.float64)[:, :3], 6), axis=0)


def _pairs(a: Array, b: Array, apart: float) -> list[tuple[Array, Array]]:
    """Return pairs of near points of two surfaces, the nearest first, each some way off the others.

    A point stands for its patch: the mean of the points about it that are nearly as near.
    """
    distance, nearest = KDTree(b).query(a)
    order = np.argsort(np.round(distance, 3), kind="stable")
    results: list[tuple[Array, Array]] = []
    free = np.ones(len(a), dtype=bool)
    for k in order:
        if not free[k]:
            continue
        about = np.linalg.norm(a - a[k], axis=1) < apart
        patch = about & (distance < distance[k] + 1.0)
        start, end = a[patch].mean(axis=0), b[nearest[patch]].mean(axis=0)
        # The mean of a ring lies off the surface: the point nearest to it does not.
        start = a[patch][int(np.argmin(np.linalg.norm(a[patch] - start, axis=1)))]
        end = b[int(np.argmin(np.linalg.norm(b - end, axis=1)))]
        results.append((start, end))
        free &= ~about
        if len(results) == TRIES:
            break
    return results


def _between(first: Any, second: Any, start: Array, end: Array, radius: float) -> Any:
    """Return the hull of what two pieces have near the ends of a strut, with a ball at each."""
    near = first ^ ball(1.6 * radius, start)
    far = second ^ ball(1.6 * radius, end)
    return hull([near, far, ball(0.8 * radius, start), ball(0.8 * radius, end)])


def _joining(first: Any, second: Any, between: Any) -> Any | None:
    """Return the piece of what is between two pieces that is in both; None if there is none.

    Slivers that a cut leaves beside it are dropped. Voids in it are filled: cut them again.
    """
    return next(
        (
            piece
            for piece in pieces(between)
            if all(float((piece ^ each).volume()) > HELD_MM3 for each in (first, second))
        ),
        None,
    )
