"""The added-mass tensor of a closed mesh, by direct boundary elements."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import RobotError
from morph.physics.fluid.tensor.closed import closed_solid
from morph.physics.fluid.tensor.influence import influence
from morph.physics.fluid.tensor.panels import Panels, panels_of

CLOSED = 1e-6
"""Most by which the solid angle that a panel sees may differ from 2 pi, over 4 pi."""

MOST = 12_000
"""Most panels: their matrix takes 1.2 GB."""


def kirchhoff(vertices: Array, faces: Integers) -> Array:
    """Return the added-mass tensor of a closed mesh at unit density, shape (6, 6).

    It acts on [v; w] about the origin of the mesh's frame; its blocks have units
    m3, m4 and m5. See `kirchhoff_of_panels` for the method.

    Args:
        vertices: Corners, shape (n, 3), m.
        faces: Triangles, counter-clockwise from outside, shape (m, 3).

    Raises:
        RobotError: The mesh is open, inside out, overlaps itself, or is no mesh.
    """
    closed_solid(vertices, faces)
    return kirchhoff_of_panels(panels_of(vertices, faces))


def kirchhoff_of_panels(panels: Panels) -> Array:
    """Return the added-mass tensor of a surface made of panels, shape (6, 6), unit density.

    The fluid's potential phi, constant on each panel, obeys at each centroid
    Green's third identity for the outside, (1/2 + H) phi = -G q, with H the double
    layer and G the single layer of `influence`, and q the six normal velocities.
    Then K = -integral of phi q' dS (Lamb 1932, art. 121; Weissmann and Pinkall 2012,
    "Underwater rigid body dynamics", sec. 3), whose antisymmetric part is error.

    Raises:
        RobotError: There are too many panels, or they do not close.
    """
    if len(panels) > MOST:
        raise RobotError(
            f"its surface has {len(panels)} panels, of at most {MOST}",
            where="morph.physics.fluid.tensor.kirchhoff",
            fix="give a coarser mesh, or use tensor_of_solid, which makes one",
        )
    matrix, pushed = influence(panels.centroids, panels, panels.flux)
    _check_closed(matrix)
    matrix[np.diag_indices_from(matrix)] += 0.5
    try:
        potential = np.linalg.solve(matrix, -pushed)
    except np.linalg.LinAlgError as error:
        raise _open("the boundary elements have no solution") from error
    tensor = -(potential * panels.areas[:, None]).T @ panels.flux
    symmetric: Array = 0.5 * (tensor + tensor.T)
    return symmetric


def _check_closed(double: Array) -> None:
    # From a place on a closed surface the rest of it fills half of all directions.
    # Surfaces within or across each other fill more.
    worst = float(np.abs(double.sum(axis=1) - 0.5).max())
    if not worst < CLOSED:
        raise _open(
            f"from one of its {len(double)} panels the rest of the surface fills "
            f"{0.5 + worst:.3g} or {0.5 - worst:.3g} of all directions, where a closed surface "
            "fills 0.5"
        )


def _open(what: str) -> RobotError:
    return RobotError(
        what,
        where="morph.physics.fluid.tensor.kirchhoff",
        fix="give one closed surface that does not cross, contain or touch itself; "
        "unite overlapping solids first",
    )
