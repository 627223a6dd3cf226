"""What came to stand for the surface of a link, and what else might have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.box import Box

How = Literal["mesh", "wrap", "hull", "box"]


@dataclass(frozen=True, kw_only=True)
class SurfaceChoice:
    """One surface that might stand for a link, and what it would mean."""

    how: str
    """`wrap`, `wrap, coarser`, `hull` or `box`."""
    volume: float
    """Volume displaced, m3."""
    added: Array
    """Diagonal of the added-mass tensor at unit density about the volume's centre, shape (6,)."""


@dataclass(frozen=True, kw_only=True)
class Wetted:
    """The surface of a link that water touches."""

    vertices: Array
    """Corners in the link's frame, m, shape (n, 3)."""
    faces: Integers
    """Triangles, counter-clockwise from outside, shape (m, 3); every piece closed."""
    volume: float
    """Volume displaced, m3."""
    centre: Array
    """Centre of that volume, shape (3,), m."""
    how: How
    """What it is: the link's own `mesh`, a `wrap` of it, its `hull`, or a `box`."""
    reason: str = ""
    """Why it is not the link's shapes as they are; empty if it is."""
    spread: Array | None = None
    """Of each diagonal entry of the added mass, the range over the choices by the entry itself,
    shape (6,); None for a surface that is as the link's shapes say."""
    choices: tuple[SurfaceChoice, ...] = ()
    """The surfaces compared; empty where there was nothing to choose."""
    box: Box | None = None
    """Set where the surface is that of one box, whose tensor has a quicker way."""


def wetted_by(
    mesh: Mesh,
    how: How,
    reason: str,
    *,
    box: Box | None = None,
    choices: tuple[SurfaceChoice, ...] = (),
    spread: Array | None = None,
) -> Wetted:
    """Return the surface that a mesh is."""
    return Wetted(
        vertices=mesh.vertices,
        faces=mesh.faces,
        volume=mesh.volume,
        centre=mesh.com,
        how=how,
        reason=reason,
        spread=spread,
        choices=choices,
        box=box,
    )
