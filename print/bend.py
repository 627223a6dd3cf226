"""A way for a strut around what it may not touch, found on a grid."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from morph.print.arrays import Array, Integers, Mask
from morph.print.mesh import from_manifold
from morph.print.solid import ball, hull, union

CELLS = 60_000
"""How many cells the grid has at most."""

FINEST_MM = 1.5
"""Least width of a cell."""

MARGIN_MM = 25.0
"""How far around the two pieces a way is looked for."""

STEPS = [
    (1, 0, 0),
    (0, 1, 0),
    (0, 0, 1),
    (1, 1, 0),
    (1, -1, 0),
    (1, 0, 1),
    (1, 0, -1),
    (0, 1, 1),
    (0, 1, -1),
]
"""From a cell to its neighbours across faces and edges; each is walked both ways."""


def bent(a: Array, b: Array, forbidden: Any, radii: Sequence[float]) -> Iterator[Any]:
    """Yield struts from one piece to another around what is forbidden: balls in a row, hulled.

    Args:
        a: Points all over the surface of one piece, shape (n, 3).
        b: Points of the other.
        forbidden: Room that must stay empty; it is cut from the strut.
        radii: Of the struts to try, mm, the best first; one for which there is no way is left out.
    """
    low = np.minimum(a.min(axis=0), b.min(axis=0)) - MARGIN_MM
    high = np.maximum(a.max(axis=0), b.max(axis=0)) + MARGIN_MM
    width = max(FINEST_MM, float(np.cbrt(np.prod(high - low) / CELLS)))
    shape = np.ceil((high - low) / width).astype(np.int64)
    cells = low + (np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1) + 0.5) * width
    clear = _clear(cells, forbidden, width)
    reach = 0.9 * width
    near = [KDTree(each).query(cells, distance_upper_bound=reach)[0] < reach for each in (a, b)]
    for radius in radii:
        free = clear > radius
        way = _shortest(free, free & near[0], free & near[1])
        if way is not None:
            places = cells.reshape(-1, 3)[way]
            ends = (a[KDTree(a).query(places[0])[1]], b[KDTree(b).query(places[-1])[1]])
            yield _along(np.vstack([ends[0], places, ends[1]]), radius) - forbidden


def _along(row: Array, radius: float) -> Any:
    """Return the hulls of balls in a row, two by two, as one."""
    balls = [ball(radius, at) for at in row[_thinned(row, 0.8 * radius)]]
    return union([hull([p, q]) for p, q in pairwise(balls)])


def _clear(cells: Array, forbidden: Any, width: float) -> Array:
    """Return how far each cell is from what is forbidden, mm, shape of the grid."""
    shape = cells.shape[:3]
    everywhere: Array = np.full(shape, np.inf)
    if forbidden.is_empty():
        return everywhere
    mesh = from_manifold(forbidden).trimesh
    inside = mesh.contains(cells.reshape(-1, 3)).reshape(shape)
    if not inside.any():
        return everywhere
    away: Array = distance_transform_edt(~inside) * width
    return away


def _shortest(free: Mask, start: Mask, end: Mask) -> Integers | None:
    """Return the cells of the shortest way through free ones, in order; None if there is none."""
    if not start.any() or not end.any():
        return None
    number = np.arange(free.size).reshape(free.shape)
    rows, columns, lengths = [], [], []
    for step in STEPS:
        here = tuple(slice(max(0, -s), free.shape[k] - max(0, s)) for k, s in enumerate(step))
        there = tuple(slice(max(0, s), free.shape[k] - max(0, -s)) for k, s in enumerate(step))
        open_ = free[here] & free[there]
        rows.append(number[here][open_])
        columns.append(number[there][open_])
        lengths.append(np.full(int(open_.sum()), float(np.linalg.norm(step))))
    data = (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns)))
    graph = coo_array(data, shape=(free.size, free.size)).tocsr()
    distance, before, _ = dijkstra(
        graph,
        directed=False,
        indices=number[start],
        return_predecessors=True,
        min_only=True,
    )
    goals = number[end]
    goal = goals[int(np.argmin(distance[goals]))]
    if not np.isfinite(distance[goal]):
        return None
    way = [int(goal)]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return np.array(way[::-1], dtype=np.int64)


def _thinned(row: Array, apart: float) -> list[int]:
    """Return which points to keep so that those kept are some way apart, both ends among them."""
    kept = [0]
    for k in range(1, len(row) - 1):
        if np.linalg.norm(row[k] - row[kept[-1]]) >= apart:
            kept.append(k)
    return [*kept, len(row) - 1]
