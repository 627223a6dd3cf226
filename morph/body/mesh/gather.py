"""Gathering the parts of a scene into one mesh, within bounds."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh.limits import FACES, too_large, unreadable
from morph.body.mesh.solid import Mesh

PARTS = 10_000
"""Most parts that a file may show; ten that each show ten others soon are a billion."""

DEEPEST = 32
"""Deepest that parts may hold each other."""


class Gathering:
    """Collects parts, each moved to its place; refuses too many before building any."""

    def __init__(self, where: str) -> None:
        self.where = where
        self._visits = 0
        self._count = 0
        self._vertices: list[Array] = [np.zeros((0, 3))]
        self._faces: list[Integers] = [np.zeros((0, 3), dtype=np.int64)]
        self._corners = 0

    def enter(self, depth: int) -> None:
        """Count a part that is about to be opened.

        Raises:
            MeshError: The parts are too many, or hold each other too deep.
        """
        self._visits += 1
        if self._visits > PARTS:
            raise too_large(f"shows more than {PARTS} parts", self.where)
        if depth > DEEPEST:
            raise unreadable(f"its parts hold each other more than {DEEPEST} deep", self.where)

    def add(self, vertices: Array, faces: Integers, place: Array) -> None:
        """Add a part's triangles under a transform, shape (4, 4), that may mirror them.

        Raises:
            MeshError: With it there are too many faces.
        """
        self._count += len(faces)
        if self._count > FACES:
            raise too_large(f"has more than the {FACES} faces allowed", self.where)
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
            raise unreadable(
                f"a face names a corner beyond the {len(vertices)} of its part", self.where
            )
        mirrored = np.linalg.det(place[:3, :3]) < 0
        self._vertices.append(vertices @ place[:3, :3].T + place[:3, 3])
        self._faces.append((faces[:, ::-1] if mirrored else faces) + self._corners)
        self._corners += len(vertices)

    def mesh(self) -> Mesh:
        """Return all parts as one mesh."""
        return Mesh(vertices=np.concatenate(self._vertices), faces=np.concatenate(self._faces))
