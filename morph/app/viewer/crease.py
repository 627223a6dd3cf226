"""Corners split along sharp edges, so that smooth shading shows edges as edges."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import Array, Integers

SHARP = math.radians(38.0)
"""Two faces that meet at a greater angle form an edge that is to be seen."""


def creased(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """Return corners and faces of the same surface, where faces share a corner only if smooth.

    A browser shades a corner by the mean of the normals of its faces. Faces around a corner
    get a corner of their own wherever no chain of smooth edges joins them.

    Args:
        vertices: Shape (vertices, 3).
        faces: Shape (faces, 3).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    vertices, faces = _welded(vertices, faces)
    first, second = _smooth_pairs(vertices, faces)
    corners = faces.size
    joined = coo_array((np.ones(len(first), dtype=bool), (first, second)), shape=(corners, corners))
    count, label = connected_components(joined, directed=False)
    where = np.empty(count, dtype=np.int64)
    where[label] = faces.ravel()
    return vertices[where], label.reshape(-1, 3).astype(np.int64)


def _welded(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """Return corners each once: files often repeat them for every face."""
    size = float(np.ptp(vertices, axis=0).max()) or 1.0
    cell = np.rint((vertices - vertices.min(axis=0)) * (1e6 / size)).astype(np.int64)
    _, one, index = np.unique(cell, axis=0, return_index=True, return_inverse=True)
    faces = index.reshape(-1)[faces]
    return vertices[one], faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]


def _smooth_pairs(vertices: Array, faces: Integers) -> tuple[Integers, Integers]:
    """Return the numbers of corners, three a face, that are one because an edge is smooth."""
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    start = np.arange(faces.size).reshape(-1, 3)
    ends = np.stack((faces, np.roll(faces, -1, axis=1)), axis=-1).reshape(-1, 2)
    spots = np.stack((start, np.roll(start, -1, axis=1)), axis=-1).reshape(-1, 2)
    # Both faces of an edge name its ends in the same order.
    swap = ends[:, 0] > ends[:, 1]
    ends[swap], spots[swap] = ends[swap][:, ::-1], spots[swap][:, ::-1]
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, spots, owner = ends[order], spots[order], order // 3
    same = (ends[1:] == ends[:-1]).all(axis=1)
    cosine = (normal[owner[1:]] * normal[owner[:-1]]).sum(axis=1)
    smooth = np.flatnonzero(same & (cosine >= math.cos(SHARP)))
    return spots[smooth].ravel(), spots[smooth + 1].ravel()
