"""Short edges of a closed mesh, collapsed onto one of their ends."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers
from morph.physics.fluid.wetted.topology import Edges, edges_of, normals

TURN = 0.8
"""Least cosine of the angle by which a collapse may turn a face."""

PASSES = 5
"""Most passes; in each, no two collapses touch."""


def collapsed(
    vertices: Array, faces: Integers, shortest: float, longest: float
) -> tuple[Array, Integers]:
    """Return a closed mesh whose short edges are collapsed, as far as its shape allows.

    A corner is moved onto a neighbour: one on a crease only along it, one where
    creases meet never. No face turns far, no edge becomes too long, and the
    surface keeps its topology (link condition: Dey et al. 1999).

    Args:
        vertices: Corners, m, shape (n, 3).
        faces: Triangles, shape (m, 3).
        shortest: Length below which an edge is collapsed, m.
        longest: Length that no edge may come to have, m.
    """
    for _ in range(PASSES):
        edges = edges_of(vertices, faces)
        merged = _Pass(vertices, faces, edges, longest)
        for edge in np.argsort(edges.length, kind="stable").tolist():
            if edges.length[edge] >= shortest:
                break
            merged.collapse(edge)
        if not merged.moved:
            break
        vertices, faces = merged.result()
    return vertices, faces


class _Pass:
    """One pass over the short edges; what a collapse touches is left alone until the next."""

    def __init__(self, vertices: Array, faces: Integers, edges: Edges, longest: float) -> None:
        self.vertices, self.faces, self.edges, self.longest = vertices, faces, edges, longest
        self.moved: dict[int, int] = {}
        self.locked: set[int] = set()
        self.around: list[list[int]] = [[] for _ in vertices]
        self.corners: list[list[int]] = faces.tolist()
        self.rings: dict[int, set[int]] = {}
        for face, corners in enumerate(self.corners):
            for corner in corners:
                self.around[corner].append(face)
        self.normal = normals(vertices, faces)

    def collapse(self, edge: int) -> None:
        a, b = (int(end) for end in self.edges.ends[edge])
        for gone, kept in ((a, b), (b, a)):
            if self._may(edge, gone) and self._fits(gone, kept):
                self.moved[gone] = kept
                self.locked |= self._ring(gone) | self._ring(kept)
                return

    def result(self) -> tuple[Array, Integers]:
        target = np.arange(len(self.vertices))
        target[list(self.moved)] = list(self.moved.values())
        faces = target[self.faces]
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
        used, index = np.unique(faces, return_inverse=True)
        return self.vertices[used], index.reshape(-1, 3).astype(np.int64)

    def _may(self, edge: int, gone: int) -> bool:
        creases = int(self.edges.creases[gone])
        return creases == 0 or (creases == 2 and bool(self.edges.crease[edge]))

    def _fits(self, gone: int, kept: int) -> bool:
        mine, other = self._ring(gone), self._ring(kept)
        if not self.locked.isdisjoint(mine) or not self.locked.isdisjoint(other):
            return False
        if len(mine & other) != 4:
            return False
        rest = [face for face in self.around[gone] if kept not in self.corners[face]]
        if len(rest) < 1 or len(self.around[kept]) + len(rest) < 5:
            return False
        moved = self.faces[rest]
        moved = np.where(moved == gone, kept, moved)
        after = normals(self.vertices, moved)
        before = self.normal[rest]
        sliver = (before == 0).sum(axis=1) == 3
        before = np.where(sliver[:, None], after, before)
        turned = np.einsum("ij,ij->i", after, before)
        reach = np.linalg.norm(self.vertices[moved] - self.vertices[kept], axis=2)
        return bool(turned.min() > TURN and reach.max() < self.longest)

    def _ring(self, corner: int) -> set[int]:
        """Return a corner and its neighbours."""
        if corner not in self.rings:
            self.rings[corner] = {c for face in self.around[corner] for c in self.corners[face]}
        return self.rings[corner]
