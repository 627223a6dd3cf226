"""Short edges of a closed mesh, collapsed onto one of their ends."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.physics.fluid.tensor.edges import Edges, edges_of, normals

SHORTEST, LONGEST = 4.0 / 5.0, 4.0 / 3.0
"""Bounds of the length of edges, as parts of the length wanted."""

TURN = 0.8
"""Least cosine of the angle by which a collapse may turn a face."""

PASSES = 60
"""Most passes; in each, collapses are as far apart as not to touch the same faces."""

DRAWS = 4
"""How often, in a pass, more collapses are chosen that are far from those chosen before."""


def collapsed(vertices: Array, faces: Integers, aim: float) -> tuple[Array, Integers]:
    """Return a closed mesh whose short edges are collapsed, as far as its shape allows.

    A corner is moved onto a neighbour: one on a crease only along it, one where
    creases meet never. No face turns far, no edge becomes too long, and the
    surface keeps its topology (link condition: Dey et al. 1999).

    Args:
        vertices: Corners, m, shape (n, 3).
        faces: Triangles, shape (m, 3).
        aim: Length wanted, m: an edge below `SHORTEST` of it goes, and none comes to be
            longer than `LONGEST` of it.
    """
    for _ in range(PASSES):
        edges = edges_of(vertices, faces)
        pairs = _candidates(edges, SHORTEST * aim)
        pairs = pairs[_fits(vertices, faces, edges, pairs, LONGEST * aim)]
        pairs = pairs[_apart(len(vertices), edges, pairs[:, 0])]
        if not len(pairs):
            break
        target = np.arange(len(vertices))
        target[pairs[:, 0]] = pairs[:, 1]
        faces = target[faces]
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
        used, index = np.unique(faces, return_inverse=True)
        vertices, faces = vertices[used], index.reshape(-1, 3).astype(np.int64)
    return vertices, faces


def _candidates(edges: Edges, shortest: float) -> Integers:
    """Return which corner may go onto which, the shortest edge first, shape (k, 2)."""
    short = np.flatnonzero(edges.length < shortest)
    short = short[np.argsort(edges.length[short], kind="stable")]
    both = np.concatenate([edges.ends[short], edges.ends[short][:, ::-1]])
    order = np.tile(np.arange(len(short)), 2)
    creases, crease = edges.creases[both[:, 0]], np.tile(edges.crease[short], 2)
    may = (creases == 0) | ((creases == 2) & crease)
    result: Integers = both[may][np.argsort(order[may], kind="stable")]
    return result


def _fits(vertices: Array, faces: Integers, edges: Edges, pairs: Integers, longest: float) -> Mask:
    """Return which corners may go without a fold, too long an edge or another topology."""
    count = len(vertices)
    around = np.argsort(faces.ravel(), kind="stable") // 3
    number = np.bincount(faces.ravel(), minlength=count)
    which, face = _spread(np.cumsum(number) - number, number, pairs[:, 0])
    face = around[face]
    gone, kept = pairs[which].T
    moved = faces[face]
    alone = (moved != kept[:, None]).all(axis=1)
    moved = np.where(moved == gone[:, None], kept[:, None], moved)
    after, before = normals(vertices, moved), normals(vertices, faces)[face]
    before = np.where((before == 0.0).all(axis=1)[:, None], after, before)
    turned = np.einsum("ij,ij->i", after, before) < TURN
    reach = np.linalg.norm(vertices[moved] - vertices[kept][:, None], axis=2).max(axis=1)
    bad = np.bincount(which, alone & (turned | (reach > longest)), minlength=len(pairs))
    fits: Mask = (bad == 0) & _linked(edges, number, pairs)
    return fits


def _linked(edges: Edges, number: Integers, pairs: Integers) -> Mask:
    """Return of which pairs only the two faces at their edge join the neighbours."""
    count = len(number)
    key = edges.ends[:, 0] * count + edges.ends[:, 1]
    start, end = np.concatenate([edges.ends, edges.ends[:, ::-1]]).T
    order = np.argsort(start, kind="stable")
    # In a closed mesh a corner has as many neighbours as faces.
    which, place = _spread(np.cumsum(number) - number, number, pairs[:, 0])
    other, kept = end[order][place], pairs[which, 1]
    wanted = np.minimum(other, kept) * count + np.maximum(other, kept)
    result = key[np.minimum(np.searchsorted(key, wanted), len(key) - 1)] == wanted
    common = np.bincount(which, result, minlength=len(pairs))
    # A corner between three faces, left with two, would make them one sheet.
    least = np.bincount(which, result & (number[other] < 4), minlength=len(pairs))
    linked: Mask = (common == 2) & (least == 0)
    return linked


def _apart(count: int, edges: Edges, gone: Integers) -> Mask:
    """Return corners, best first, whose neighbourhoods share nothing with each other's."""
    chosen: Mask = np.zeros(len(gone), dtype=bool)
    taken = np.zeros(count, dtype=np.int64)
    for _ in range(DRAWS):
        free = np.flatnonzero(_near(edges, taken, np.maximum)[gone] == 0)
        rank = np.full(count, len(gone), dtype=np.int64)
        np.minimum.at(rank, gone[free], free)
        least = _near(edges, _near(edges, rank, np.minimum), np.minimum)
        drawn = free[least[gone[free]] == free]
        if not len(drawn):
            break
        chosen[drawn] = True
        mark = np.zeros(count, dtype=np.int64)
        mark[gone[drawn]] = 1
        taken = np.maximum(taken, _near(edges, mark, np.maximum))
    return chosen


def _near(edges: Edges, values: Integers, best: np.ufunc) -> Integers:
    """Return the best of the values of each corner and its neighbours."""
    result: Integers = values.copy()
    best.at(result, edges.ends[:, 0], values[edges.ends[:, 1]])
    best.at(result, edges.ends[:, 1], values[edges.ends[:, 0]])
    return result


def _spread(first: Integers, number: Integers, chosen: Integers) -> tuple[Integers, Integers]:
    """Return, for each entry of the lists of the chosen, whose it is and where it stands."""
    size = number[chosen]
    which = np.repeat(np.arange(len(chosen)), size)
    step = np.arange(len(which)) - np.repeat(np.cumsum(size) - size, size)
    return which, first[chosen][which] + step
