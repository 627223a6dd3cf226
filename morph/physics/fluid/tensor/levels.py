"""One solid on two sizes of panels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.body.mesh import Mesh
from morph.physics.fluid.tensor.cluster import clustered
from morph.physics.fluid.tensor.even import even
from morph.physics.fluid.tensor.panels import Panels, panels_of
from morph.physics.fluid.tensor.sharp import is_edged

SMOOTH, EDGED = 2.0, 4.0 / 3.0
"""Order at which the error falls with the size of the panels; see `extrapolated`."""

ENOUGH = 6
"""Corners of the mesh for each corner of a coarser one, below which clusters are ragged."""


@dataclass(frozen=True, kw_only=True)
class Levels:
    """One solid on large and on small panels, both about the centre of its volume."""

    coarse: Panels
    """The large ones, about a quarter as many."""
    fine: Panels
    """The small ones."""
    order: float
    """Power of the panels' size with which the error falls."""

    @property
    def ratio(self) -> float:
        """Size of the large ones by that of the small ones."""
        return float(np.sqrt(len(self.fine) / len(self.coarse)))


def levels(solid: Mesh, panels: int) -> Levels:
    """Return a solid on about `panels` panels and on a quarter of them.

    Raises:
        RobotError: It cannot be remeshed.
    """
    edged = is_edged(solid)
    # A mesh that has about as many panels as wanted is better than any made of it.
    near = 0.5 * panels < len(solid.faces) <= panels
    fine = solid if near else _remeshed(solid, panels, edged)
    coarse = _remeshed(solid, panels // 4, edged)
    return Levels(
        coarse=_fitted(coarse, solid), fine=_fitted(fine, solid), order=EDGED if edged else SMOOTH
    )


def _remeshed(solid: Mesh, panels: int, edged: bool) -> Mesh:
    if edged or len(solid.faces) < panels:
        return even(solid, panels)
    dense = solid
    while len(dense.vertices) < ENOUGH * panels / 2:
        dense = _divided(dense)
    return clustered(dense, panels) or even(solid, panels)


def _divided(mesh: Mesh) -> Mesh:
    """Return a mesh with each triangle in four, by the middles of its edges."""
    ends = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    pairs, which = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    middle = len(mesh.vertices) + which.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = mesh.faces.T, middle.T
    four = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return Mesh(
        vertices=np.concatenate([mesh.vertices, mesh.vertices[pairs].mean(axis=1)]),
        faces=np.concatenate([np.stack(face, axis=1) for face in four]),
    )


def _fitted(mesh: Mesh, solid: Mesh) -> Panels:
    """Return panels about their centre, grown to the volume of the solid that they stand for."""
    grown = np.cbrt(solid.volume / mesh.volume)
    return panels_of((mesh.vertices - mesh.com) * grown, mesh.faces)
