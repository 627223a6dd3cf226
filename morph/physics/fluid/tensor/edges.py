"""The edges of a closed mesh: who their faces are, how they fold, what meets at their ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers, Mask

FOLD = np.cos(np.radians(40.0))
"""Cosine of the fold from which on an edge is a crease; those of an icosahedron fold by 42."""

SLIVER = 1e-3
"""Height by longest side below which a triangle's own normal says nothing."""

BENT = 9
"""Creases said to meet in a corner where two do, but at an angle."""


@dataclass(frozen=True, kw_only=True)
class Edges:
    """Every edge of a closed mesh once, with its two faces."""

    ends: Integers
    """Its two corners, the lower number first, shape (edges, 2)."""
    faces: Integers
    """The face on either side, first the one that runs from the lower; shape (edges, 2)."""
    tips: Integers
    """The third corner of each of those faces, shape (edges, 2)."""
    length: Array
    """m, shape (edges,)."""
    crease: Mask
    """Whether its faces fold sharply, shape (edges,)."""
    convex: Mask
    """Whether its faces fold so that it juts out, shape (edges,)."""
    creases: Integers
    """How many creases meet in each corner, or `BENT`; shape (corners,)."""


def edges_of(vertices: Array, faces: Integers) -> Edges:
    """Return the edges of a closed, consistently wound mesh."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    tip, face = np.roll(faces, -2, axis=1).ravel(), np.repeat(np.arange(len(faces)), 3)
    low, high = np.minimum(start, end), np.maximum(start, end)
    # Both directions of an edge stand side by side, the rising one first.
    pairs = np.argsort((low * len(vertices) + high) * 2 + (start > end)).reshape(-1, 2)
    ends = np.stack([low, high], axis=1)[pairs[:, 0]]
    normal = normals(vertices, faces)
    both = face[pairs]
    fold = np.einsum("ij,ij->i", normal[both[:, 0]], normal[both[:, 1]])
    # A sliver has no normal to speak of: its neighbours alone hold its corners.
    crease: Mask = (fold < FOLD) & (normal != 0).any(axis=1)[both].all(axis=1)
    along = vertices[ends[:, 1]] - vertices[ends[:, 0]]
    length = np.sqrt((along * along).sum(axis=1))
    unit = along[crease] / np.maximum(length[crease], np.finfo(float).tiny)[:, None]
    across = vertices[tip[pairs[:, 1]]] - vertices[ends[:, 0]]
    return Edges(
        ends=ends,
        faces=both,
        tips=tip[pairs],
        length=length,
        crease=crease,
        convex=np.einsum("ij,ij->i", across, normal[both[:, 0]]) < 0.0,
        creases=_creases(len(vertices), ends[crease], unit),
    )


def normals(vertices: Array, faces: Integers) -> Array:
    """Return the unit normal of each face, shape (faces, 3); zero for a sliver."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    p, q, r = b - a, c - b, a - c
    cross = np.cross(r, p)
    size = np.sqrt((cross * cross).sum(axis=1))
    longest = np.maximum(np.maximum((p * p).sum(axis=1), (q * q).sum(axis=1)), (r * r).sum(axis=1))
    flat = size > SLIVER * longest
    unit: Array = cross * (flat / np.where(flat, size, 1.0))[:, None]
    return unit


def _creases(corners: int, ends: Integers, along: Array) -> Integers:
    count = np.bincount(ends.ravel(), minlength=corners)
    # Two creases that go on in the same direction cancel: |a + b|^2 = 2 - 2 cos(bend).
    total = np.zeros((corners, 3))
    np.add.at(total, ends[:, 0], along)
    np.add.at(total, ends[:, 1], -along)
    bent = (total**2).sum(axis=1) > 2.0 - 2.0 * FOLD
    return np.where((count == 2) & bent, BENT, count)
