"""A mesh with fewer faces, for engines that take no more."""

from __future__ import annotations

import numpy as np

from morph.arrays import Integers
from morph.body.mesh.solid import Mesh

MOST_CORNERS = 2_000_000
"""Most corners of which three fit into one whole number of 63 bits, as (2e6)^3 < 2^63."""


def thinned(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh of at most so many faces; itself if it has no more.

    Corners in one cell of a grid become their mean, and faces that so lose a corner go
    (Rossignac and Borrel 1993, vertex clustering). The finest grid that is coarse
    enough is found by halving the interval.
    """
    if len(mesh.faces) <= most:
        return mesh
    low, high = 1, 4096
    best = _clustered(mesh, low)
    while low + 1 < high:
        middle = (low + high) // 2
        candidate = _clustered(mesh, middle)
        if len(candidate.faces) <= most:
            low, best = middle, candidate
        else:
            high = middle
    return best


def _clustered(mesh: Mesh, cells: int) -> Mesh:
    low, high = mesh.bounds
    size = float((high - low).max()) / cells or 1.0
    cell = np.floor((mesh.vertices - low) / size).astype(np.int64)
    code = (cell[:, 0] * (cells + 2) + cell[:, 1]) * (cells + 2) + cell[:, 2]
    _, index, count = np.unique(code, return_inverse=True, return_counts=True)
    mean = np.zeros((len(count), 3))
    for axis in range(3):
        mean[:, axis] = np.bincount(index, mesh.vertices[:, axis]) / count
    faces = index[mesh.faces]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return Mesh(vertices=mean, faces=_distinct(faces[whole], len(mean)))


def _distinct(faces: Integers, count: int) -> Integers:
    """Return each face once, in rising order; one number a face sorts faster than three."""
    if count > MOST_CORNERS:
        return np.unique(faces, axis=0)
    code = np.sort((faces[:, 0] * count + faces[:, 1]) * count + faces[:, 2])
    code = code[np.diff(code, prepend=-1) > 0]
    return np.stack((code // count**2, code // count % count, code % count), axis=1)
