"""From the triangles of shapes to one solid, if they bound one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh
from morph.physics.fluid.tensor.manifold import as_manifold, from_manifold

SAMPLES = 48
"""Faces beside which a piece is asked whether it has an inside and an outside."""

SLIVER = 1e-6
"""Part of the whole volume below which a separate piece is no part of the body."""

AT_ONCE = 400_000
"""Solid angles worked out at once, to keep memory small."""


@dataclass(frozen=True, kw_only=True)
class Joined:
    """What shapes bound together."""

    mesh: Mesh | None
    """The solid; None if some piece bounds nothing."""
    notes: tuple[str, ...]
    """What was mended, or why there is none; empty for shapes without a fault."""


def joined(shapes: tuple[Mesh, ...], *, grown: float = 0.0) -> Joined:
    """Return the union of shapes as one solid, its faces outward, its pieces apart.

    Pieces of a shape that are closed are turned right side out, so that hollows
    are filled: water does not get in. What overlaps is counted once. A body may
    consist of several solids that do not touch: each has an inside.

    Args:
        shapes: Triangle meshes, m.
        grown: By how much each piece is made larger all round, m, so that what only
            touches overlaps.
    """
    notes: list[str] = []
    solids: list[Mesh] = []
    for shape in shapes:
        pieces = pieces_of(_tidy(shape))
        bad = [fault for piece in pieces if (fault := fault_of(piece))]
        if bad:
            return Joined(mesh=None, notes=(_counted(bad, len(pieces)),))
        turned = sum(piece.volume < 0 for piece in pieces)
        if turned:
            notes.append(f"{turned} of {len(pieces)} pieces were inside out and were turned")
        solids += [_outward(piece) for piece in pieces]
    mesh = _union([_grown(solid, grown) for solid in solids] if grown else solids)
    if mesh is None:
        return Joined(mesh=None, notes=("its pieces cannot be joined exactly",))
    return Joined(mesh=mesh, notes=tuple(dict.fromkeys(notes)))


def pieces_of(mesh: Mesh) -> tuple[Mesh, ...]:
    """Return the pieces of a mesh that share no corner."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(mesh.vertices)
    start, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    edges = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(count, count))
    _, label = connected_components(edges, directed=False)
    of_face = label[mesh.faces[:, 0]]
    order = np.argsort(of_face, kind="stable")
    cuts = np.flatnonzero(np.diff(of_face[order])) + 1
    return tuple(
        Mesh(vertices=mesh.vertices, faces=mesh.faces[part]).merged
        for part in np.split(order, cuts)
        if len(part)
    )


def fault_of(piece: Mesh) -> str:
    """Return why a piece bounds no solid: `open`, `flat` or `tangled`; empty if it does."""
    if not piece.watertight:
        return "open"
    if piece.hollow:
        return "flat"
    if not piece.consistent or _tangled(_outward(piece)):
        return "tangled"
    return ""


def winding(points: Array, mesh: Mesh, *, without: Integers | None = None) -> Array:
    """Return how often a surface winds around points, shape (points,); 1 inside a solid.

    Source: Jacobson, Kavan and Sorkine-Hornung 2013, "Robust inside-outside
    segmentation using generalized winding numbers", eq. 5: the solid angles
    (Van Oosterom and Strackee 1983) of all faces over 4 pi.

    Args:
        points: Where, m, shape (points, 3).
        mesh: The surface.
        without: For each point a face to leave out, shape (points,).
    """
    middle = mesh.bounds.mean(axis=0)
    corners = mesh.vertices - middle
    a, b, c = corners[mesh.faces].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    ab, bc, ca = (((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    total = np.zeros(len(points))
    block = max(1, AT_ONCE // len(mesh.faces))
    for start in range(0, len(points), block):
        here = points[start : start + block] - middle
        away = np.sqrt(sum((here[:, i, None] - corners[:, i]) ** 2 for i in range(3)))
        la, lb, lc = (away[:, mesh.faces[:, i]] for i in range(3))
        # With p, q and r from the point to the corners: p . (q x r) is p . normal, and
        # 2 p . q = |p|^2 + |q|^2 - |p - q|^2.
        triple = (a * normal).sum(axis=1) - here @ normal.T
        below = la * lb * lc
        below += 0.5 * lc * (la * la + lb * lb - ab)
        below += 0.5 * la * (lb * lb + lc * lc - bc)
        below += 0.5 * lb * (lc * lc + la * la - ca)
        angle = np.arctan2(triple, below)
        if without is not None:
            angle[np.arange(len(here)), without[start : start + block]] = 0.0
        total[start : start + block] = angle.sum(axis=1) / (2.0 * np.pi)
    return total


def _tangled(mesh: Mesh) -> bool:
    """Whether a closed surface crosses itself, as far as a few of its faces can tell."""
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    # The largest faces: beside a sliver neither side is clear of its neighbours.
    chosen = np.argsort(-twice)[: 4 * SAMPLES : 4]
    chosen = chosen[twice[chosen] > 0]
    normal = cross[chosen] / twice[chosen][:, None]
    # Not so far that a thin body is left on the other side.
    near = np.minimum(1e-4 * np.sqrt(twice[chosen]), 0.1 * mesh.volume / twice.sum())
    away = near[:, None] * normal
    middle = corners[chosen].mean(axis=1)
    result = np.concatenate([winding(middle - away, mesh) - 1.0, winding(middle + away, mesh)])
    return bool((np.abs(result) > 0.5).any())


def _tidy(shape: Mesh) -> Mesh:
    """Return a shape with its corners merged, without faces that have no area or stand twice."""
    faces = shape.merged.faces
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Mesh(vertices=shape.merged.vertices, faces=faces[np.sort(first)])


def _outward(piece: Mesh) -> Mesh:
    if piece.volume > 0:
        return piece
    return Mesh(vertices=piece.vertices, faces=piece.faces[:, ::-1].copy())


def _grown(piece: Mesh, length: float) -> Mesh:
    middle, half = piece.bounds.mean(axis=0), np.ptp(piece.bounds, axis=0) / 2.0
    return Mesh(
        vertices=middle + (piece.vertices - middle) * (1.0 + length / half), faces=piece.faces
    )


def _union(solids: list[Mesh]) -> Mesh | None:
    from manifold3d import Error, Manifold, OpType

    if len(solids) == 1:
        return solids[0]
    parts = [as_manifold(solid) for solid in solids]
    if any(part.status() != Error.NoError for part in parts):
        return None
    whole = Manifold.batch_boolean(parts, OpType.Add)
    kept = [piece for piece in whole.decompose() if piece.volume() > SLIVER * whole.volume()]
    return from_manifold(Manifold.compose(kept)) if kept else None


def _counted(faults: list[str], pieces: int) -> str:
    kinds = [f"{faults.count(kind)} {kind}" for kind in dict.fromkeys(faults)]
    return f"{' and '.join(kinds)} of its {pieces} piece{'s' if pieces > 1 else ''}"
