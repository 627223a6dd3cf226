"""How much of a mesh's surface meets in sharp edges."""

from __future__ import annotations

import numpy as np

from morph.body.mesh import Mesh

TURN = np.radians(40.0)
"""Angle between the normals of two faces from which their edge is sharp."""


def is_edged(mesh: Mesh) -> bool:
    """Return whether a watertight mesh has edges, rather than being smooth all over.

    It has if its sharp edges together are longer than half the root of its area: a
    cube's are 4.9 times that root, and a sphere in 320 panels has none.
    """
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    twice = np.cross(b - a, c - a)
    size = np.linalg.norm(twice, axis=1)
    normals = twice / np.maximum(size, np.finfo(float).tiny)[:, None]
    ends = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    ends = np.sort(ends, axis=1)
    order = np.lexsort(ends.T)
    # Each edge now stands twice in a row, once for each of its faces.
    ends, face = ends[order][::2], (order // 3).reshape(-1, 2)
    cosine = np.einsum("ij,ij->i", normals[face[:, 0]], normals[face[:, 1]])
    sharp = ends[cosine < np.cos(TURN)]
    length = np.linalg.norm(np.diff(mesh.vertices[sharp], axis=1), axis=2).sum()
    return bool(length > 0.5 * np.sqrt(0.5 * size.sum()))
