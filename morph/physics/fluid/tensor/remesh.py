"""A solid's surface in triangles of about one size, as boundary elements want them."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.body.mesh import Mesh
from morph.physics.fluid.tensor.collapse import LONGEST, collapsed
from morph.physics.fluid.tensor.edges import Edges, edges_of, normals
from morph.physics.fluid.tensor.manifold import simplified

ROUNDS = 6
"""How often edges are split, collapsed and flipped, and corners moved."""

FINER = (200.0, 100.0, 50.0, 25.0, 12.0)
"""Edges wanted, by what the surface may be off before it is cut into them, tried in turn."""

ENOUGH = 4
"""Times the panels that a surface may have at first; more take long and say no more."""

LONGER = 1.05
"""How much longer than in equal triangles edges may be, as some of theirs are shorter."""

FLIPS = 10
"""Most rounds of flips that touch no face twice."""

HALVINGS = 40
"""Most rounds of halving: each edge that is too long waits for at most a few others."""


def remeshed(mesh: Mesh, panels: int) -> Mesh:
    """Return a closed mesh as about so many triangles of about one size, of the same volume.

    Edges longer than 4/3 of the aim are split, shorter than 4/5 collapsed, and
    flipped where the angles opposite add to more than pi; corners move to the
    middle of their neighbours (Botsch and Kobbelt 2004, "A remeshing approach to
    multiresolution modeling"). Creases stay. Parts thinner than a triangle keep
    their thickness, and may make more of them.
    """
    aim = LONGER * edge_for(mesh, panels)
    lean = mesh
    for finer in FINER:
        lean = simplified(lean, aim / finer)
        if len(lean.faces) < ENOUGH * panels:
            break
    vertices, faces = lean.vertices, _flipped(lean.vertices, lean.faces)
    for _ in range(ROUNDS):
        vertices, faces = collapsed(vertices, faces, aim)
        vertices, faces = split(vertices, faces, LONGEST * aim)
        faces = _flipped(vertices, faces)
        vertices = _relaxed(vertices, faces)
    result = Mesh(vertices=vertices, faces=faces)
    if not result.volume > 0.0:
        return result
    grown = (mesh.volume / result.volume) ** (1.0 / 3.0)
    return Mesh(vertices=mesh.com + grown * (vertices - result.com), faces=faces)


def edge_for(mesh: Mesh, panels: int) -> float:
    """Return the edge of equal triangles, m, of which so many cover the surface of a mesh."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)
    return float(np.sqrt(4.0 / np.sqrt(3.0) * area / panels))


def evenness(mesh: Mesh) -> float:
    """Return how near to equilateral all but the worst twentieth of triangles are; at most 1.

    Of a triangle, 4 sqrt(3) area / sum of squared sides.
    """
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    squares = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    return float(np.quantile(2.0 * np.sqrt(3.0) * twice / squares, 0.05))


def split(vertices: Array, faces: Integers, longest: float) -> tuple[Array, Integers]:
    """Return the mesh with the longest sides of triangles halved until none is too long."""
    for _ in range(HALVINGS):
        edges = edges_of(vertices, faces)
        # The longest side of both its faces: then no neighbour is cut askew.
        chosen = _best(len(faces), edges.faces, -edges.length) & (edges.length > longest)
        if not chosen.any():
            break
        vertices, faces = _halved(vertices, faces, edges.ends[chosen], edges.faces[chosen])
        # Needles would be cut into ever more of them.
        faces = _flipped(vertices, faces, 1)
    return vertices, faces


def _best(count: int, faces: Integers, cost: Array) -> Mask:
    """Return which pairs of faces are the cheapest of both their faces."""
    rank = np.empty(len(cost), dtype=np.int64)
    rank[np.argsort(cost, kind="stable")] = np.arange(len(cost))
    least = np.full(count, len(cost), dtype=np.int64)
    np.minimum.at(least, faces.ravel(), np.repeat(rank, 2))
    best: Mask = (least[faces] == rank[:, None]).all(axis=1)
    return best


def _halved(
    vertices: Array, faces: Integers, ends: Integers, sides: Integers
) -> tuple[Array, Integers]:
    middle = len(vertices) + np.arange(len(ends))
    vertices = np.concatenate([vertices, vertices[ends].mean(axis=1)])
    added, faces = [], faces.copy()
    for side in sides.T:
        face = faces[side]
        faces[side] = np.where(face == ends[:, :1], middle[:, None], face)
        added.append(np.where(face == ends[:, 1:], middle[:, None], face))
    return vertices, np.concatenate([faces, *added])


def _flipped(vertices: Array, faces: Integers, rounds: int = FLIPS) -> Integers:
    """Return the faces with the diagonals of flat pairs swapped where that widens angles."""
    for _ in range(rounds):
        edges = edges_of(vertices, faces)
        turned = _may_turn(vertices, faces, edges)
        if not len(turned):
            break
        (a, b), (c, d) = edges.ends[turned].T, edges.tips[turned].T
        faces = faces.copy()
        # The rising edge a to b has its left face first: (a, b, c) and (b, a, d).
        faces[edges.faces[turned, 0]] = np.stack([a, d, c], axis=1)
        faces[edges.faces[turned, 1]] = np.stack([b, c, d], axis=1)
    return faces


def _may_turn(vertices: Array, faces: Integers, edges: Edges) -> Integers:
    p, q = vertices[edges.ends[:, 0]], vertices[edges.ends[:, 1]]
    left, right = vertices[edges.tips].transpose(1, 0, 2)
    angle = _angle(p - left, q - left) + _angle(p - right, q - right)
    wide = np.flatnonzero((angle > np.pi + 1e-6) & ~edges.crease)
    (a, b), (c, d) = edges.ends[wide].T, edges.tips[wide].T
    key = edges.ends[:, 0] * len(vertices) + edges.ends[:, 1]
    new = np.minimum(c, d) * len(vertices) + np.maximum(c, d)
    before = normals(vertices, faces[edges.faces[wide]].reshape(-1, 3)).reshape(-1, 2, 3)
    worst = np.ones(len(wide))
    for after in (np.stack([a, d, c], axis=1), np.stack([b, c, d], axis=1)):
        cosine = np.einsum("ij,ikj->ik", normals(vertices, after), before)
        # A sliver has no normal; what it becomes need only agree with its neighbour.
        worst = np.minimum(worst, np.where((before == 0.0).all(axis=2), 1.0, cosine).min(axis=1))
    good = wide[(worst > 0.9) & (c != d) & ~np.isin(new, key)]
    # Two flips at once must not make the same edge: of such, neither is made.
    made = np.minimum(*edges.tips[good].T) * len(vertices) + np.maximum(*edges.tips[good].T)
    _, first, times = np.unique(made, return_index=True, return_counts=True)
    good = good[np.sort(first[times == 1])]
    result: Integers = good[_best(len(faces), edges.faces[good], -angle[good])]
    return result


def _relaxed(vertices: Array, faces: Integers) -> Array:
    """Return corners moved within the surface towards the middle of their neighbours."""
    edges = edges_of(vertices, faces)
    (a, b), count = edges.ends.T, len(vertices)
    total, normal = np.zeros((2, count, 3))
    np.add.at(total, a, vertices[b])
    np.add.at(total, b, vertices[a])
    number = np.bincount(edges.ends.ravel(), minlength=count)
    before = normals(vertices, faces)
    for at in range(3):
        np.add.at(normal, faces[:, at], before)
    size = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
    normal /= size[:, None]
    step = total / number[:, None] - vertices
    step -= np.einsum("ij,ij->i", step, normal)[:, None] * normal
    step[edges.creases > 0] = 0.0
    for _ in range(3):
        moved = vertices + step
        turned = np.einsum("ij,ij->i", normals(moved, faces), before) < 0.9
        if not turned.any():
            return moved
        step[faces[turned].ravel()] = 0.0
    return vertices


def _angle(a: Array, b: Array) -> Array:
    across = np.linalg.norm(np.cross(a, b), axis=1)
    angle: Array = np.arctan2(across, np.einsum("ij,ij->i", a, b))
    return angle
