"""Triangle meshes of the shapes that a description knows by name, with their exact volumes."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh

AROUND = 32
"""Corners of the polygon that stands for a circle."""


def box_mesh(sides: Array) -> Mesh:
    """Return a box about the origin from its three sides, m, as 12 triangles."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return Mesh(vertices=signs * sides / 2.0, faces=faces)


def ellipsoid_mesh(radii: Array) -> Mesh:
    """Return an ellipsoid about the origin from its three radii, m, as 1280 triangles.

    An icosahedron whose faces are split in four, three times, and pushed onto
    the sphere; it is then grown until it encloses 4/3 pi a b c.
    """
    golden = (1.0 + math.sqrt(5.0)) / 2.0
    ring = np.array([(0.0, s, t * golden) for s in (-1, 1) for t in (-1, 1)])
    corners = np.concatenate([np.roll(ring, turn, axis=1) for turn in range(3)])
    solid = Mesh(vertices=corners, faces=np.arange(12, dtype=np.int64).reshape(-1, 3)).hull
    for _ in range(3):
        vertices, faces = quartered(solid.vertices, solid.faces)
        solid = Mesh(vertices=vertices / np.linalg.norm(vertices, axis=1)[:, None], faces=faces)
    grown = (4.0 / 3.0 * math.pi / solid.volume) ** (1.0 / 3.0)
    return Mesh(vertices=solid.vertices * grown * radii, faces=solid.faces)


def cylinder_mesh(radius: float, length: float) -> Mesh:
    """Return a cylinder along z about the origin, m."""
    half = length / 2.0
    rows = max(1, round(length / (2.0 * math.pi * radius / AROUND)))
    side = [(radius, z) for z in np.linspace(-half, half, rows + 1)]
    return revolved([(0.0, -half), (radius / 2, -half), *side, (radius / 2, half), (0.0, half)])


def capsule_mesh(radius: float, length: float) -> Mesh:
    """Return a cylinder along z about the origin that ends in half balls, m."""
    half = length / 2.0
    rows = max(1, round(length / (2.0 * math.pi * radius / AROUND)))
    angles = np.linspace(-math.pi / 2, 0.0, AROUND // 4 + 1)[1:-1]
    end = [(radius * math.cos(a), radius * math.sin(a) - half) for a in angles]
    side = [(radius, float(z)) for z in np.linspace(-half, half, rows + 1)]
    other = [(r, -z) for r, z in reversed(end)]
    pole = half + radius
    mesh = revolved([(0.0, -pole), *end, *side, *other, (0.0, pole)])
    exact = math.pi * radius**2 * (length + 4.0 / 3.0 * radius)
    # The half balls are polygons too; what they lack is added all over.
    return Mesh(vertices=mesh.vertices * (exact / mesh.volume) ** (1.0 / 3.0), faces=mesh.faces)


def revolved(profile: list[tuple[float, float]]) -> Mesh:
    """Return the solid that a profile sweeps about z.

    Args:
        profile: Radius and height, m, from the lower pole to the upper; the
            first and the last radius are 0, no other.

    Returns:
        The mesh; its polygons have the area of the circles that they stand for.
    """
    turn = 2.0 * math.pi / AROUND
    # Area of a regular polygon of n corners at radius R: n/2 R^2 sin(2 pi / n).
    wider = math.sqrt(turn / math.sin(turn))
    rings = []
    angle = turn * np.arange(AROUND)
    for radius, height in profile[1:-1]:
        level = np.full(AROUND, height)
        rings.append(
            np.stack([wider * radius * np.cos(angle), wider * radius * np.sin(angle), level], 1)
        )
    poles = np.array([[0.0, 0.0, profile[0][1]], [0.0, 0.0, profile[-1][1]]])
    vertices = np.concatenate([poles, *rings])
    around = np.arange(AROUND)
    after = (around + 1) % AROUND
    last = 2 + AROUND * (len(rings) - 1)
    faces = [
        np.stack([np.zeros_like(around), 2 + after, 2 + around], axis=1),
        np.stack([np.ones_like(around), last + around, last + after], axis=1),
    ]
    for row in range(len(rings) - 1):
        low, high = 2 + AROUND * row, 2 + AROUND * (row + 1)
        a, b, c, d = low + around, low + after, high + around, high + after
        faces += [np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]
    return Mesh(vertices=vertices, faces=np.concatenate(faces).astype(np.int64))


def quartered(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """Return the mesh with each triangle split into four at the middles of its edges."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    edges, index = np.unique(sides, axis=0, return_inverse=True)
    middle = len(vertices) + index.reshape(-1, 3)
    a, b, c = faces.T
    ab, bc, ca = middle.T
    split = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return (
        np.concatenate([vertices, vertices[edges].mean(axis=1)]),
        np.concatenate([np.stack(corner, axis=1) for corner in split]),
    )
