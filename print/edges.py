"""The edges of a mesh: which are open, which are shared by too many, which wind the wrong way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Integers
from morph.print.mesh import Mesh


@dataclass(frozen=True, kw_only=True, eq=False)
class DirectedEdges:
    """Directed edges, three a triangle, and what of them keeps a mesh from being closed."""

    directed: Integers
    """From corner to corner, triangle after triangle, shape (3 m, 2)."""
    edge: Integers
    """The undirected edge of each, shape (3 m,)."""
    along: Integers
    """How often each undirected edge is walked from its lower corner up, shape (k,)."""
    against: Integers
    """How often it is walked down, shape (k,)."""

    @property
    def open(self) -> int:
        """How many edges belong to a single triangle."""
        return int((self.along + self.against == 1).sum())

    @property
    def crowded(self) -> int:
        """How many edges belong to more than two triangles."""
        return int((self.along + self.against > 2).sum())

    @property
    def twisted(self) -> int:
        """How many edges lie between two triangles that wind differently."""
        return int(((self.along + self.against == 2) & (self.along != self.against)).sum())

    @property
    def closed(self) -> bool:
        """Whether each edge is walked as often one way as the other, so that a volume is meant."""
        return bool((self.along == self.against).all())


def edges(mesh: Mesh) -> DirectedEdges:
    """Return the edges of a mesh; corners count as one only if they have one index."""
    directed = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    low, high = directed.min(axis=1), directed.max(axis=1)
    _, edge = np.unique(low * (int(high.max(initial=0)) + 1) + high, return_inverse=True)
    up = directed[:, 0] < directed[:, 1]
    count = int(edge.max(initial=-1)) + 1
    return DirectedEdges(
        directed=directed,
        edge=edge.astype(np.int64),
        along=np.bincount(edge[up], minlength=count),
        against=np.bincount(edge[~up], minlength=count),
    )


def trouble(mesh: Mesh) -> str:
    """Return in words why a mesh is not closed; empty if it is."""
    result = edges(mesh)
    named = (
        (result.open, "open (one face only)"),
        (result.crowded, "shared by more than two faces"),
        (result.twisted, "between faces that wind differently"),
    )
    return ", ".join(
        f"{count} edge{'s' if count > 1 else ''} {what}" for count, what in named if count
    )
