"""The added-mass tensor of a solid, whatever number of faces its mesh has."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor.closed import closed_solid
from morph.physics.fluid.tensor.extrapolate import difference, extrapolated
from morph.physics.fluid.tensor.kirchhoff import MOST
from morph.physics.fluid.tensor.levels import EDGED, SMOOTH, Levels, levels
from morph.physics.fluid.tensor.tensor import Tensor

FEWEST = 64
"""Fewest panels: their quarter still covers every side of a tetrahedron with four."""

STEP = 0.2
"""Greatest estimated error with which the limit is still believed, rather than the fine value."""

ALONE = 0.1
"""Error owned up to where there is one size of panels only: what a bad step amounts to."""

RIM = 0.06
"""Error by panels' length over the solid's thickness: of boxes, at 0.5 to 2, 4 to 11 %."""

LEAST = 1e-6
"""Least inertia of the fluid along any motion, as a part of that of the fluid displaced."""

WRONG = 0.05
"""Negative inertia, as such a part, beyond what extrapolation leaves of a ball that turns."""


def tensor_of_solid(
    vertices: ArrayLike, faces: ArrayLike, *, panels: int = 1280, extrapolate: bool = True
) -> Tensor:
    """Return the added-mass tensor of a closed mesh about the origin of its frame.

    The surface is remeshed to about `panels` triangles and to a quarter of
    them, unless it already has about as many. What the two differ by gives the
    limit, at an order between that of smooth and that of edged surfaces; the error is what
    either would change, or, of thin solids, what is known of their rims.

    Args:
        vertices: Corners, shape (n, 3), m.
        faces: Triangles, counter-clockwise from outside, shape (m, 3).
        panels: Triangles of the finer surface. Time grows as the square: a second at 1280.
        extrapolate: Whether the limit is returned, or the value on the finer surface.

    Raises:
        RobotError: The mesh is not one closed, outward surface, or `panels` is out of bounds.
    """
    if not FEWEST <= panels <= MOST:
        raise RobotError(
            f"panels = {panels}",
            where="morph.physics.fluid.tensor.tensor_of_solid",
            fix=f"give {FEWEST} to {MOST}; 1280 serve for most solids",
        )
    solid = closed_solid(vertices, faces)
    # At unit volume about the centre, so that no metre is hidden in a tolerance.
    size = float(np.cbrt(solid.volume))
    unit = Mesh(vertices=(solid.vertices - solid.com) / size, faces=solid.faces)
    both = levels(unit, panels)
    scale = np.concatenate([np.ones(3), np.diag(unit.inertia)])
    limit, error = _limit(both, scale)
    chosen = limit if extrapolate and error < STEP else both.fine.matrix
    about_centre = Tensor(
        matrix=positive(chosen, scale), volume=1.0, error=error, panels=len(both.fine.mesh.faces)
    )
    return about_centre.scaled(size).shifted(solid.com)


def _limit(both: Levels, scale: Array) -> tuple[Array, float]:
    fine = both.fine.matrix
    if both.coarse is None:
        return fine, ALONE
    quick, limit, slow = (
        extrapolated(both.coarse.matrix, fine, ratio=both.ratio, order=order)
        for order in (SMOOTH, both.order, EDGED)
    )
    error = max(difference(quick, limit, scale), difference(slow, limit, scale))
    return limit, error if both.order == SMOOTH else max(error, RIM * both.slender)


def positive(matrix: Array, scale: Array) -> Array:
    """Return the nearest tensor with which every motion meets some inertia.

    Eigenvalues are those relative to `scale`. A ball that turns moves no fluid, so
    that rounding and extrapolation may leave a little less than nothing.

    Args:
        matrix: Tensor about the centre of the volume, shape (6, 6).
        scale: What the displaced fluid resists the six motions with were it solid, shape (6,).

    Raises:
        RobotError: An eigenvalue is negative by more than rounding and extrapolation explain.
    """
    root = np.sqrt(np.outer(scale, scale))
    values, axes = np.linalg.eigh(matrix / root)
    if values[0] < -WRONG:
        raise RobotError(
            f"one motion of it would meet {values[0]:.3g} times the inertia of the fluid displaced",
            where="morph.physics.fluid.tensor: the mesh",
            fix="thicken what is thinner than the panels, raise `panels`, or take its convex hull",
        )
    clipped = (axes * np.maximum(values, LEAST)) @ axes.T
    even: Array = 0.5 * (clipped + clipped.T) * root
    return even
