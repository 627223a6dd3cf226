"""Shapes to cover with panels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

Shape = tuple[np.ndarray, np.ndarray]


def divided(vertices: np.ndarray, faces: np.ndarray) -> Shape:
    """The same surface with each triangle in four."""
    place: dict[tuple[int, int], int] = {}
    corners = [tuple(corner) for corner in vertices]

    def middle(one: int, other: int) -> int:
        pair = (min(one, other), max(one, other))
        if pair not in place:
            place[pair] = len(corners)
            corners.append(tuple((np.array(corners[one]) + corners[other]) / 2))
        return place[pair]

    four = []
    for a, b, c in faces.tolist():
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        four += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.array(corners), np.array(four)


def icosphere(level: int) -> Shape:
    """A unit sphere in 20 * 4^level triangles."""
    g = (1 + 5**0.5) / 2
    corners = [(0, y, z * g) for y in (-1, 1) for z in (-1, 1)]
    corners = corners + [c[2:] + c[:2] for c in corners] + [c[1:] + c[:1] for c in corners]
    vertices = np.array(corners, dtype=float)
    # Neighbours are 2 apart; three that are mutual neighbours are a face.
    near = np.abs(np.linalg.norm(vertices[:, None] - vertices, axis=2) - 2) < 1e-9
    found = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[c, a]
    ]
    turn = [np.linalg.det(vertices[list(face)]) > 0 for face in found]
    faces = np.array([f if out else f[::-1] for f, out in zip(found, turn, strict=True)])
    for _ in range(level):
        vertices, faces = divided(vertices, faces)
        vertices = vertices / np.linalg.norm(vertices, axis=1)[:, None]
    return vertices / np.linalg.norm(vertices, axis=1)[:, None], faces


@pytest.fixture(scope="session")
def ball() -> Callable[[int], Shape]:
    """Unit spheres in 20 * 4^level triangles, each made once."""
    made: dict[int, Shape] = {}
    return lambda level: made.setdefault(level, icosphere(level))


@pytest.fixture
def cube() -> Shape:
    """A unit cube about the origin in 12 triangles."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) - 0.5
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))])
