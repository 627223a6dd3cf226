"""Which motion lays one solid on another that is the same but for its triangles."""

from __future__ import annotations

import itertools

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh as Surface
from morph.fabrication.solids import placed
from morph.print.errors import SolidError
from morph.print.mesh import Mesh

ALIKE = 2e-4
"""How much volumes and moments may differ, as a part of them."""

DISTINCT = 1e-2
"""Least difference of two principal moments, as a part of them, that fixes an axis."""

SKIN_MM = 0.02
"""Thickness of the layer between two surfaces that are the same, on average."""


def laid(one: Mesh, other: Mesh) -> Array | None:
    """Return the motion that lays one solid on another, shape (4, 4); None if there is none.

    Both are turned so that their principal axes agree, in the eight ways there are, proper ones
    first, and what they then have in common is compared with their volumes. Of a solid with
    equal principal moments, such as a ball, the axes are not known, and nothing is found.
    """
    if abs(one.volume - other.volume) > ALIKE * abs(one.volume) or one.volume <= 0.0:
        return None
    (middle, moments, axes), (there, alike, others) = _principal(one), _principal(other)
    if np.abs(moments - alike).max() > 5.0 * ALIKE * moments.max():
        return None
    if np.diff(moments).min() < DISTINCT * moments.max():
        return None
    skin = SKIN_MM * _area(one)
    turns = [others @ np.diag(s) @ axes.T for s in itertools.product((1.0, -1.0), repeat=3)]
    for turn in sorted(turns, key=lambda turn: bool(np.linalg.det(turn) < 0)):
        pose = placed(turn, there - turn @ middle)
        try:
            common = float((one.moved(pose).manifold ^ other.manifold).volume())
        except SolidError:
            return None
        if one.volume - common < skin:
            return pose
    return None


def _principal(mesh: Mesh) -> tuple[Array, Array, Array]:
    """Return a solid's middle, its principal moments in order, and their axes as columns."""
    surface = Surface(vertices=mesh.vertices, faces=mesh.faces)
    moments, axes = np.linalg.eigh(surface.inertia)
    return surface.com, moments, axes


def _area(mesh: Mesh) -> float:
    a, b, c = mesh.corners.transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)
