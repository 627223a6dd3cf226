"""One solid on two sizes of panels, as far as its shape allows them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor.edges import edges_of
from morph.physics.fluid.tensor.kirchhoff import MOST, kirchhoff_of_panels
from morph.physics.fluid.tensor.panels import Panels, panels_of
from morph.physics.fluid.tensor.remesh import edge_for, evenness, remeshed, split

FINER = (1.0, 1.6, 2.5)
"""Times the panels asked for that are tried in turn, as thin parts need smaller ones."""

EVEN = 0.4
"""Evenness of a mesh from which on it serves as it is."""

SMOOTH, EDGED = 2.0, 4.0 / 3.0
"""Order at which the error falls with the size of the panels; see `extrapolated`."""

CUBE = 12.0 / 6.0**0.5
"""Length of a cube's edges by the root of its area."""


@dataclass(frozen=True, kw_only=True)
class PanelLevel:
    """A tensor on panels of one size."""

    mesh: Mesh
    """The surface, about the centre of its volume."""
    matrix: Array
    """The tensor about that centre, shape (6, 6)."""


@dataclass(frozen=True, kw_only=True)
class Levels:
    """One solid's tensors on large and on small panels."""

    fine: PanelLevel
    """On small panels."""
    coarse: PanelLevel | None
    """On about a quarter as many; None if none was found that does not cross itself."""
    order: float
    """Power of the panels' size with which the error falls."""
    slender: float
    """Length of the small panels' edges by the solid's mean thickness."""

    @property
    def ratio(self) -> float:
        """Size of the large panels by that of the small ones; 1 without large ones."""
        large = self.coarse or self.fine
        return float(np.sqrt(len(self.fine.mesh.faces) / len(large.mesh.faces)))


def levels(solid: Mesh, panels: int) -> Levels:
    """Return a solid's tensors on about `panels` panels and on a quarter of them.

    Raises:
        RobotError: It crosses or touches itself on any panels.
    """
    fine = _first(solid, _surfaces(solid, panels))
    try:
        fewer = panels // 4
        coarse = _first(solid, (remeshed(fine.mesh, round(more * fewer)) for more in FINER[:2]))
    except RobotError:
        # The small panels stand on their own, with the error that this means.
        coarse = None
    if coarse is not None and 2 * len(coarse.mesh.faces) > len(fine.mesh.faces):
        coarse = None
    area = panels_of(fine.mesh.vertices, fine.mesh.faces).areas.sum()
    return Levels(
        fine=fine,
        coarse=coarse,
        order=order_of(solid),
        slender=edge_for(fine.mesh, len(fine.mesh.faces)) * float(area) / (2.0 * solid.volume),
    )


def order_of(mesh: Mesh) -> float:
    """Return the power of the panels' size with which the error on a watertight mesh falls.

    From `SMOOTH` without edges that jut out, in proportion to the length of those, to
    `EDGED` where they are as long as a cube's, 4.9 times the root of its area. Edges
    that point inward, where bodies are joined, slow nothing down.
    """
    edges = edges_of(mesh.vertices, mesh.faces)
    length = edges.length[edges.crease & edges.convex].sum()
    root = float(np.sqrt(panels_of(mesh.vertices, mesh.faces).areas.sum()))
    return SMOOTH - (SMOOTH - EDGED) * min(1.0, float(length) / (CUBE * root))


def _surfaces(solid: Mesh, panels: int) -> Iterator[Mesh]:
    """Give surfaces on which the solid may be computed, the best first."""
    if 0.5 * panels < len(solid.faces) <= panels and evenness(solid) > EVEN:
        # A good mesh of about as many panels as wanted is better than any made of it.
        yield solid
    for more in FINER:
        yield remeshed(solid, round(more * panels))
    # Halving edges moves nothing: a solid that does not cross itself will not then.
    vertices, faces = split(solid.vertices, solid.faces, 2.0 * edge_for(solid, panels))
    yield Mesh(vertices=vertices, faces=faces)


def _first(solid: Mesh, surfaces: Iterator[Mesh]) -> PanelLevel:
    """Return the first surface that closes without crossing itself, with its tensor."""
    refused = RobotError(
        "its surface crosses or touches itself on any panels",
        where="morph.physics.fluid.tensor: the mesh",
        fix="unite overlapping parts, wrap it, or take its convex hull",
    )
    for mesh in surfaces:
        if len(mesh.faces) > MOST or not mesh.consistent or not mesh.volume > 0.0:
            continue
        try:
            fitted = _fitted(mesh, solid)
            return PanelLevel(mesh=mesh, matrix=kirchhoff_of_panels(fitted))
        except RobotError as error:
            refused = error
    raise refused


def _fitted(mesh: Mesh, solid: Mesh) -> Panels:
    """Return panels about their centre, grown to the volume of the solid that they stand for."""
    grown = np.cbrt(solid.volume / mesh.volume)
    return panels_of((mesh.vertices - mesh.com) * grown, mesh.faces)
