"""A solid's surface in triangles of about one size, as boundary elements want them."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.collapse import collapsed
from morph.physics.fluid.wetted.solid import as_manifold, from_manifold
from morph.physics.fluid.wetted.sound import sound
from morph.physics.fluid.wetted.topology import edges_of, normals

ROUNDS, MOST_ROUNDS = 3, 6
"""How often edges are split, collapsed and flipped, and how often while there are too many."""

LONGER = 1.12
"""How much longer than in equal triangles edges may be, as some of theirs are shorter."""

CHANGED = 0.1
"""Part of the volume that remeshing may take or give before the mesh stays as it was."""

COARSER, ENOUGH = 3, 3840
"""Times the faces asked for, and the least, to which a finer mesh is first simplified."""

FINER = (1.0, 1.6, 2.5)
"""Times the faces asked for that are tried in turn, as thin parts need smaller ones."""


def even(mesh: Mesh, panels: int) -> Mesh:
    """Return a closed mesh as about so many triangles of about one size, of the same volume.

    Edges longer than 4/3 of the aim are split, shorter than 4/5 collapsed, and
    flipped where the angles opposite add to more than pi (Botsch and Kobbelt
    2004, "A remeshing approach to multiresolution modeling"). Corners only
    move onto other corners, and creases stay. Of a mesh that does not survive
    this as a solid the long edges are split, and that is all.
    """
    found = _simplified(mesh, max(COARSER * panels, ENOUGH))
    for finer in FINER:
        result = _remeshed(found, round(finer * panels))
        if abs(result.volume / mesh.volume - 1.0) <= CHANGED and sound(result):
            grown = (mesh.volume / result.volume) ** (1.0 / 3.0)
            moved = mesh.com + grown * (result.vertices - result.com)
            return Mesh(vertices=moved, faces=result.faces)
    # Halving edges moves nothing.
    longest = 4.0 / 3.0 * edge_for(mesh, panels)
    vertices, faces = _split(mesh.vertices, mesh.faces, longest)
    return Mesh(vertices=vertices, faces=faces)


def _remeshed(mesh: Mesh, panels: int) -> Mesh:
    vertices, faces = mesh.vertices, mesh.faces
    aim = LONGER * edge_for(mesh, panels)
    for turn in range(MOST_ROUNDS):
        if turn >= ROUNDS and len(faces) < 1.25 * panels:
            break
        vertices, faces = _split(vertices, faces, 4.0 / 3.0 * aim)
        vertices, faces = collapsed(vertices, faces, 4.0 / 5.0 * aim, 4.0 / 3.0 * aim)
        faces = _flipped(vertices, faces)
    return Mesh(vertices=vertices, faces=faces)


def edge_for(mesh: Mesh, panels: int) -> float:
    """Return the edge of equal triangles, m, of which so many cover the surface of a mesh."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)
    return float(np.sqrt(4.0 / np.sqrt(3.0) * area / panels))


def _simplified(mesh: Mesh, most: int) -> Mesh:
    """Return a mesh of at most about so many faces, off by as little as that takes."""
    if len(mesh.faces) <= most:
        return mesh
    solid = as_manifold(mesh)
    size = float(np.linalg.norm(mesh.bounds[1] - mesh.bounds[0]))
    for part in np.geomspace(1e-6, 0.01, 13):
        simple = solid.simplify(part * size)
        if simple.num_tri() <= most:
            break
    found = from_manifold(simple)
    return found if found.consistent and len(found.faces) > 3 else mesh


def _split(vertices: Array, faces: Integers, longest: float) -> tuple[Array, Integers]:
    """Return the mesh with the longest side of triangles halved until none is too long."""
    for _ in range(24):
        edges = edges_of(vertices, faces)
        # The longest side of both its faces, or of neither's: then no neighbour is cut askew.
        order = np.argsort(-edges.length, kind="stable")
        free = np.ones(len(faces), dtype=bool)
        chosen = []
        for edge in order[: int((edges.length > longest).sum())].tolist():
            left, right = edges.faces[edge]
            if free[left] and free[right]:
                free[left] = free[right] = False
                chosen.append(edge)
        if not chosen:
            break
        vertices, faces = _halved(vertices, faces, edges.ends[chosen], edges.faces[chosen])
    return vertices, faces


def _halved(
    vertices: Array, faces: Integers, ends: Integers, sides: Integers
) -> tuple[Array, Integers]:
    middle = len(vertices) + np.arange(len(ends))
    vertices = np.concatenate([vertices, vertices[ends].mean(axis=1)])
    added = []
    faces = faces.copy()
    for side in range(2):
        face = faces[sides[:, side]]
        first = np.where(face == ends[:, :1], middle[:, None], face)
        second = np.where(face == ends[:, 1:], middle[:, None], face)
        faces[sides[:, side]] = first
        added.append(second)
    return vertices, np.concatenate([faces, *added])


def _flipped(vertices: Array, faces: Integers) -> Integers:
    """Return the faces with the diagonals of flat pairs swapped where that widens angles."""
    edges = edges_of(vertices, faces)
    p, q = vertices[edges.ends[:, 0]], vertices[edges.ends[:, 1]]
    left, right = vertices[edges.tips].transpose(1, 0, 2)
    angle = _angle(p - left, q - left) + _angle(p - right, q - right)
    known = {(int(a), int(b)) for a, b in edges.ends}
    faces = faces.copy()
    free = np.ones(len(faces), dtype=bool)
    wanted = np.flatnonzero((angle > np.pi + 1e-6) & ~edges.crease)
    for edge in wanted[np.argsort(-angle[wanted])].tolist():
        pair, (a, b), (c, d) = edges.faces[edge], edges.ends[edge], edges.tips[edge]
        new = (int(min(c, d)), int(max(c, d)))
        if not free[pair].all() or new in known or c == d:
            continue
        # The rising edge a to b has its left face first: (a, b, c) and (b, a, d).
        swapped = np.array([[a, d, c], [b, c, d]])
        after = normals(vertices, swapped)
        if (after @ normals(vertices, faces[pair]).T).min() > 0.9:
            faces[pair], free[pair] = swapped, False
            known.add(new)
    return faces


def _angle(a: Array, b: Array) -> Array:
    across = np.linalg.norm(np.cross(a, b), axis=1)
    angle: Array = np.arctan2(across, np.einsum("ij,ij->i", a, b))
    return angle
