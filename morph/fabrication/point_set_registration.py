"""Rigid registration of two sets of named points, if there is one."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial import KDTree

from morph.arrays import Array

SAME = 0.01
"""How near each point must come to its like, mm."""

MOST_TRIED = 200
"""Most motions that are tried for one pair of sets."""


def motion(one: Array, other: Array) -> Array | None:
    """Return the motion that lays `one` on `other`, shape (4, 4); None if there is none.

    Proper motions are found before mirrors, and those that keep directions before others.

    Args:
        one: Points, mm, each with a number that says what it is, shape (n, 4).
        other: The same of the second set, shape (m, 4).
    """
    if len(one) != len(other) or len(one) == 0:
        return None
    middles = one[:, :3].mean(axis=0), other[:, :3].mean(axis=0)
    reach = [_reach(points, middle) for points, middle in zip((one, other), middles, strict=True)]
    if np.abs(np.sort(reach[0]) - np.sort(reach[1])).max() > SAME:
        return None
    tree = KDTree(other * (1.0, 1.0, 1.0, 1e3))
    for turn in itertools.chain(SIGNS, _turns(one, other, middles, reach)):
        pose = np.eye(4)
        pose[:3, :3] = turn
        pose[:3, 3] = middles[1] - turn @ middles[0]
        if _lies(one, pose, tree):
            return pose
    return None


def cloud(*labelled: tuple[float, Array]) -> Array:
    """Return points with their labels, shape (n, 4), from labels and points of shape (n, 3)."""
    rows = [np.column_stack([points, np.full(len(points), label)]) for label, points in labelled]
    return np.concatenate(rows) if rows else np.zeros((0, 4))


def _reach(points: Array, middle: Array) -> Array:
    """Return how far each point is from the middle, moved apart by what it is."""
    away: Array = np.linalg.norm(points[:, :3] - middle, axis=1) + 1e3 * points[:, 3]
    return away


def _lies(one: Array, pose: Array, tree: KDTree) -> bool:
    moved = np.column_stack([one[:, :3] @ pose[:3, :3].T + pose[:3, 3], 1e3 * one[:, 3]])
    away, at = tree.query(moved, distance_upper_bound=SAME)
    return bool(np.isfinite(away).all()) and len(np.unique(at)) >= 0.99 * len(at)


def _turns(
    one: Array, other: Array, middles: tuple[Array, Array], reach: list[Array]
) -> list[Array]:
    """Return rotations, then mirrors, that lay two rare points of the one on like ones."""
    a, b = one[:, :3] - middles[0], other[:, :3] - middles[1]
    order = np.argsort(reach[1])
    first_of, end_of = (np.searchsorted(reach[1][order], reach[0] + by) for by in (-SAME, SAME))
    many = end_of - first_of
    # The fewer points a point could be laid on, the fewer motions there are to try.
    rare = np.lexsort((-np.linalg.norm(a, axis=1), many))
    first = rare[0]
    across = np.linalg.norm(np.cross(a[first], a[rare]), axis=1)
    if across.max() < SAME:
        return []
    second = rare[np.argmax(across > 0.1 * across.max())]
    firsts, seconds = (order[first_of[at] : end_of[at]] for at in (first, second))
    proper, mirrors = [], []
    frame = _frame(a[first], a[second])
    for p, q in itertools.product(firsts, seconds):
        if abs(a[first] @ a[second] - b[p] @ b[q]) > SAME * np.linalg.norm(a[first]) * 2.0:
            continue
        to = _frame(b[p], b[q])
        proper.append(to @ frame.T)
        mirrors.append(to @ np.diag([1.0, 1.0, -1.0]) @ frame.T)
        if len(proper) >= MOST_TRIED:
            break
    return [*proper, *mirrors]


def _frame(first: Array, second: Array) -> Array:
    """Return axes as columns: along the first, then in the plane of both, then across it."""
    x = first / np.linalg.norm(first)
    z = np.cross(first, second)
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


SIGNS = tuple(
    sorted(
        (np.diag(signs) for signs in itertools.product((1.0, -1.0), repeat=3)),
        key=lambda turn: (np.linalg.det(turn) < 0, np.sum(turn < 0)),
    )
)
"""Turns that keep the axes' directions: proper ones first, the identity before all."""
