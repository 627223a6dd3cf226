"""Whether a surface is fit for boundary elements."""

from __future__ import annotations

import numpy as np

from morph.body.mesh import Mesh
from morph.physics.fluid.tensor.edges import normals
from morph.physics.fluid.wetted.solid import winding

HALF = 1e-6
"""How far what a panel sees of its own surface may be from half of all directions."""

PAIRS = 4_000_000
"""Solid angles worked out at most, so that it takes a fraction of a second."""


def sound(mesh: Mesh) -> bool:
    """Whether a closed surface neither crosses, touches nor holds another of its parts.

    From the middle of a panel, the rest of a closed surface fills half of all
    directions; where panels cross or lie on each other, it does not. Needles, that
    unions leave, are not asked, and on a fine mesh only every so many panels are.
    """
    if not mesh.consistent or not mesh.volume > 0:
        return False
    plain = np.flatnonzero((normals(mesh.vertices, mesh.faces) != 0.0).any(axis=1))
    requested = plain[:: 1 + len(plain) * len(mesh.faces) // PAIRS]
    middles = mesh.vertices[mesh.faces[requested]].mean(axis=1)
    seen = winding(middles, mesh, without=requested)
    return bool((np.abs(seen - 0.5) < HALF).all())
