"""How far a mended mesh is from the one that was given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array, Mask
from morph.print.edges import edges
from morph.print.errors import SolidError
from morph.print.facets import merged
from morph.print.mesh import Mesh
from morph.print.samples import samples

MIXERS = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)
"""Odd numbers of 64 bits with no pattern, to make one number of three."""
POINTS = 400
"""Points taken on the faces that changed, on each side."""


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """What a repair changed."""

    volume: float | None
    """Change by the volume before; None where the mesh before encloses none."""
    distance_mm: float
    """Greatest distance found from either surface to the other."""


def deviation(before: Mesh, after: Mesh) -> Deviation:
    """Return how far two meshes are apart; faces that both have are apart by nothing."""
    # A soup of triangles encloses something if it does with its corners made one.
    was = before.volume if edges(merged(before)).closed else 0.0
    lost, gained = _not_in(before, after), _not_in(after, before)
    return Deviation(
        volume=abs(after.volume - was) / abs(was) if was else None,
        distance_mm=max(_distance(before, lost, after), _distance(after, gained, before)),
    )


def _not_in(mesh: Mesh, other: Mesh) -> Mask:
    """Return which faces have no twin in the other mesh, to a micrometre, however wound."""
    mine, theirs = _names(mesh), _names(other)
    return ~np.isin(mine, theirs)


def _names(mesh: Mesh) -> Array:
    """Return a number for each face that its three corners settle in any order."""
    places = np.round(mesh.vertices * 1e3).astype(np.int64).astype(np.uint64)
    corners = np.zeros(len(places), dtype=np.uint64)
    for column, mixer in zip(places.T, MIXERS, strict=True):
        corners = (corners ^ (corners >> np.uint64(29))) + column * np.uint64(mixer)
        corners ^= corners >> np.uint64(32)
    of_faces = np.sort(corners[mesh.faces], axis=1)
    names: Array = (of_faces * np.array(MIXERS, dtype=np.uint64)).sum(axis=1)
    return names


def _distance(mesh: Mesh, chosen: Mask, other: Mesh) -> float:
    """Return the greatest distance from points on chosen faces to the other surface, mm."""
    if not chosen.any():
        return 0.0
    import trimesh

    try:
        result = samples(Mesh(vertices=mesh.vertices, faces=mesh.faces[chosen]), POINTS).points
    except SolidError:
        # What changed has no area: nobody can be far from it.
        return 0.0
    _, apart, _ = trimesh.proximity.closest_point(  # type: ignore[no-untyped-call]
        other.trimesh, result
    )
    return float(apart.max())
