"""A smooth mesh with fewer triangles of about one size, by clustering its corners."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh

ROUNDS = 12
"""Rounds of moving each seed to the middle of its cluster; more change little."""

TRIES = 4
"""Starts from other seeds before it is given up."""

FACING = 0.5
"""Weight of a corner's normal beside its place; it keeps the two sides of a fin apart."""

FLATTEST = 1e-3
"""Curvature of a quadric, by its greatest, below which it says nothing along that axis."""


def clustered(mesh: Mesh, panels: int) -> Mesh | None:
    """Return a closed mesh of about so many triangles, or None if none was found.

    Corners are clustered by place and normal (Lloyd 1982), each cluster becomes the
    place nearest to the planes of its faces (Garland and Heckbert 1997, sec. 4),
    and faces with corners in three clusters remain (Valette and Chassery 2004).

    Args:
        mesh: A closed, smooth mesh with several times as many corners as the result.
        panels: Triangles wanted.
    """
    twice, normals, areas = _at_corners(mesh)
    count = panels // 2 + 2
    size = np.sqrt(areas.sum() / count)
    features = np.concatenate([mesh.vertices, FACING * size * normals], axis=1)
    for seed in range(TRIES):
        label, seeds = _lloyd(features, areas, count, np.random.default_rng(seed))
        found = _joined(mesh, twice, label, seeds[:, :3])
        # A neck or a fin thinner than a cluster may lose its manifold.
        if len(found.faces) and found.consistent:
            return found
    return None


def _at_corners(mesh: Mesh) -> tuple[Array, Array, Array]:
    """Return twice the area vectors of faces, and corners' unit normals and areas."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    twice = np.cross(b - a, c - a)
    normals = np.zeros_like(mesh.vertices)
    areas = np.zeros(len(normals))
    for at in range(3):
        np.add.at(normals, mesh.faces[:, at], twice)
        np.add.at(areas, mesh.faces[:, at], np.linalg.norm(twice, axis=1) / 6.0)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    return twice, normals / np.where(size > 0.0, size, 1.0), areas


def _lloyd(
    features: Array, weight: Array, count: int, rng: np.random.Generator
) -> tuple[Integers, Array]:
    # Loads a library that few need.
    from scipy.spatial import cKDTree

    probability = weight / weight.sum()
    seeds = features[rng.choice(len(features), count, replace=False, p=probability)]
    for _ in range(ROUNDS):
        label = cKDTree(seeds).query(features)[1]
        total = np.bincount(label, weight, minlength=count)
        middle = np.zeros_like(seeds)
        np.add.at(middle, label, weight[:, None] * features)
        full = total > 0.0
        seeds[full] = middle[full] / total[full, None]
    return np.asarray(cKDTree(seeds).query(features)[1], dtype=np.int64), seeds


def _joined(mesh: Mesh, twice: Array, label: Integers, middle: Array) -> Mesh:
    """Return the mesh whose corners are clusters, each at the best place for its faces."""
    size = np.linalg.norm(twice, axis=1)
    normals = twice / np.maximum(size, np.finfo(float).tiny)[:, None]
    curvature, pull = np.zeros((len(middle), 3, 3)), np.zeros((len(middle), 3))
    outer = size[:, None, None] * normals[:, :, None] * normals[:, None, :]
    for at in range(3):
        cluster = label[mesh.faces[:, at]]
        height = np.einsum("ij,ij->i", mesh.vertices[mesh.faces[:, 0]] - middle[cluster], normals)
        np.add.at(curvature, cluster, outer)
        np.add.at(pull, cluster, (size * height)[:, None] * normals)
    values, axes = np.linalg.eigh(curvature)
    known = values > FLATTEST * np.maximum(values[:, -1:], np.finfo(float).tiny)
    inverse = np.where(known, 1.0 / np.where(known, values, 1.0), 0.0)
    corners = middle + np.einsum("nij,nj,nkj,nk->ni", axes, inverse, axes, pull)
    faces = label[mesh.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Mesh(vertices=corners, faces=faces[np.sort(first)])
