"""Exact mends of single facets: what is degenerate or double, flipped, or missing."""

from __future__ import annotations

import numpy as np

from morph.print.arrays import Array, Integers, Mask
from morph.print.edges import edges
from morph.print.mesh import Mesh

CRACK_MM = 0.02
"""Corners of open edges that are closer than this are taken for one."""
FLAT = 0.01
"""Furthest that the rim of a hole may leave its plane, mm."""


def merged(mesh: Mesh) -> Mesh:
    """Return the mesh with coinciding corners as one, and those that no face uses left out.

    Corners coincide if they agree to 2^-21 of the mesh's size, the rounding of a few steps in
    the float32 of an STL.
    """
    import trimesh

    size = float(np.abs(mesh.vertices).max())
    digits = int(np.clip(np.floor(-np.log10(size * 2.0**-21)), 0, 9))
    result = trimesh.Trimesh(vertices=mesh.vertices, faces=mesh.faces, process=False)
    result.merge_vertices(digits_vertex=digits)
    result.remove_unreferenced_vertices()
    return Mesh(
        vertices=np.asarray(result.vertices, dtype=np.float64),
        faces=np.asarray(result.faces, dtype=np.int64),
    )


def without_cracks(mesh: Mesh) -> Mesh:
    """Return the mesh with open edges that lie side by side joined at their corners.

    `manifold3d.Mesh64.merge` does this only to its own precision, 1e-12 of the mesh's size: it
    does not heed the tolerance that it is given.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    result = edges(mesh)
    lonely = (result.along + result.against == 1)[result.edge]
    rim = np.unique(result.directed[lonely])
    pairs = cKDTree(mesh.vertices[rim]).query_pairs(CRACK_MM, output_type="ndarray")
    if not len(pairs):
        return mesh
    graph = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(rim),) * 2)
    _, group = connected_components(graph, directed=False)
    _, first = np.unique(group, return_index=True)
    place = np.arange(len(mesh.vertices))
    place[rim] = rim[first[group]]
    return Mesh(vertices=mesh.vertices, faces=place[mesh.faces])


def without_doubles(mesh: Mesh) -> Mesh:
    """Return the mesh without faces of two corners, and with each other face once.

    Two faces back to back enclose nothing; both go.
    """
    faces = mesh.faces
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    if not len(faces):
        return Mesh(vertices=mesh.vertices, faces=faces)
    _, first, group = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True
    )
    group = group.ravel()
    # A triple of corners is wound like its sorted order or against it, +1 or -1.
    order = np.argsort(faces, axis=1)
    sign = np.where((order[:, 0] + 1) % 3 == order[:, 1], 1, -1)
    balance = np.bincount(group, weights=sign, minlength=len(first))
    count = np.bincount(group, minlength=len(first))
    kept = np.flatnonzero((balance != 0) | (count == 1))
    # Of faces that wind alike the first stays; of an uneven mix one that winds as most do.
    agrees = sign == np.sign(balance)[group]
    place = np.full(len(first), len(faces))
    np.minimum.at(place, group[agrees], np.flatnonzero(agrees))
    return Mesh(vertices=mesh.vertices, faces=faces[np.sort(place[kept])])


def wound_alike(mesh: Mesh) -> Mesh:
    """Return the mesh with the faces of each connected patch wound as most of its area is.

    Most by area and not by the sign of the volume: the shell of a void is rightly inside out.
    Each face stands in a graph twice, as it is and turned over, and is joined to those of its
    neighbours that wind alike; so a patch falls into two components, of which one is chosen.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, other, alike = _neighbours(mesh)
    count = len(mesh.faces)
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([other, other + count])
    columns = np.where(np.tile(alike, 2), columns, (columns + count) % (2 * count))
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * count, 2 * count))
    _, patch = connected_components(graph, directed=False)
    a, b, c = mesh.corners.transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept = np.bincount(patch[:count], weights=area, minlength=int(patch.max()) + 1)
    wrong = kept[patch[count:]] > kept[patch[:count]]
    return Mesh(
        vertices=mesh.vertices, faces=np.where(wrong[:, None], mesh.faces[:, ::-1], mesh.faces)
    )


def _neighbours(mesh: Mesh) -> tuple[Integers, Integers, Mask]:
    """Return the pairs of faces that share an edge with no third, and whether they wind alike."""
    result = edges(mesh)
    order = np.argsort(result.edge, kind="stable")
    shared = (result.along + result.against == 2)[result.edge[order]]
    first, second = order[shared].reshape(-1, 2).T
    # Neighbours that wind alike walk their edge in opposite directions.
    alike = result.directed[first, 0] != result.directed[second, 0]
    return first // 3, second // 3, alike


def turned(mesh: Mesh) -> Mesh:
    """Return the mesh with its inside out."""
    return Mesh(vertices=mesh.vertices, faces=mesh.faces[:, ::-1].copy())


def filled(mesh: Mesh) -> Mesh:
    """Return the mesh with each hole that has a flat rim closed; others stay open."""
    import manifold3d

    caps = []
    for rim in rims(mesh):
        corners = mesh.vertices[rim]
        middle = corners.mean(axis=0)
        _, _, axes = np.linalg.svd(corners - middle)
        if np.abs((corners - middle) @ axes[2]).max() > FLAT:
            continue
        flat = (corners - middle) @ axes[:2].T
        # The cap runs along the rim as the hole sees it: against the faces around.
        if _shoelace(flat) < 0:
            flat = flat * [1.0, -1.0]
        try:
            caps.append(rim[np.asarray(manifold3d.triangulate([flat]), dtype=np.int64)])
        except RuntimeError:
            continue
    if not caps:
        return mesh
    return Mesh(vertices=mesh.vertices, faces=np.concatenate([mesh.faces, *caps]))


def rims(mesh: Mesh) -> list[Integers]:
    """Return the loops of open edges, each as corners in the order in which a cap runs."""
    result = edges(mesh)
    lonely = (result.along + result.against == 1)[result.edge]
    # A neighbour walks a shared edge the other way.
    after = {int(b): int(a) for a, b in result.directed[lonely]}
    loops = []
    while after:
        first = next(iter(after))
        loop, at = [first], after.pop(first)
        while at != first and at in after:
            loop.append(at)
            at = after.pop(at)
        if at == first and len(loop) > 2:
            loops.append(np.array(loop, dtype=np.int64))
    return loops


def _shoelace(flat: Array) -> float:
    x, y = flat.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0
