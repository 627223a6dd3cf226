"""Drag from the pressure on a surface's panels, or on a box's faces; per unit density."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from morph.arrays import Array, Integers
from morph.errors import RobotError

BLUFF = 1.1
"""Pressure coefficient of a panel that meets the flow squarely.

Between that of a cube, 1.05, and of a square plate, 1.17, at Reynolds numbers
above 1000 (Hoerner 1965, "Fluid-Dynamic Drag", section 3).
"""

WATER_VISCOSITY = 1.0e-3
"""Of fresh water at 20 degrees, Pa s."""

_ROOT = math.sqrt(15.0)
_NEAR, _FAR = (6.0 - _ROOT) / 21.0, (6.0 + _ROOT) / 21.0
POINTS = np.array(
    [[1 / 3, 1 / 3, 1 / 3]]
    + [[1 - 2 * p if i == j else p for j in range(3)] for p in (_NEAR, _FAR) for i in range(3)]
)
"""Where a triangle is sampled, as weights of its corners, shape (7, 3)."""

WEIGHTS = np.array([0.225] + [(155.0 - _ROOT) / 1200.0] * 3 + [(155.0 + _ROOT) / 1200.0] * 3)
"""Of those points; exact for polynomials of degree 5 (Radon 1948; Dunavant 1985)."""


def panel_drag(
    vertices: Array,
    faces: Integers,
    *,
    coefficient: float = BLUFF,
    point: ArrayLike = (0.0, 0.0, 0.0),
) -> Array:
    """Return the quadratic drag of a closed surface along and about its frame's axes.

    Where the surface moves outward at speed u, a pressure 1/2 rho C u^2 resists,
    and behind it there is none (Newton 1687, Principia, book II, prop. 34, with C
    for his 4). With s = (n, r x n) a unit motion along or about axis i moves a panel
    outward at s_i, so the mean over both directions is, per unit density,
    q_i = C/4 integral of |s_i|^3 dA: force_i = -rho q_i v_i |v_i|.

    Args:
        vertices: Corners, m, shape (n, 3).
        faces: Triangles, counter-clockwise from outside, shape (m, 3).
        coefficient: C, of a panel that meets the flow squarely.
        point: Place through which the axes of rotation go, m, shape (3,).

    Returns:
        q: three along the axes, m2, and three about them, m5; shape (6,).

    Raises:
        RobotError: The coefficient is negative or not finite.
    """
    _check("coefficient", coefficient, "morph.physics.fluid.wetted.panel_drag")
    corners = np.asarray(vertices)[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    normal = cross / np.where(twice > 0, twice, 1.0)[:, None]
    total = np.zeros(6)
    for place, weight in zip(POINTS, WEIGHTS, strict=True):
        arm = np.einsum("c,fcx->fx", place, corners) - np.asarray(point, dtype=np.float64)
        outward = np.concatenate([normal, np.cross(arm, normal)], axis=1)
        total += weight * twice / 2.0 @ np.abs(outward) ** 3
    return coefficient / 4.0 * total


def box_drag(sides: ArrayLike, coefficients: ArrayLike = (BLUFF, BLUFF, BLUFF)) -> Array:
    """Return the quadratic drag of a box along and about its axes, through its centre.

    Along x, of sides a, b, c and coefficients Cx, Cy, Cz: q = 1/2 Cx b c. About x,
    strips of the faces beside the axis move at z and y: q = a (Cy c^4 + Cz b^4) / 64;
    the others by turns (Georgiades 2005, the 15 parameters of a body).

    Args:
        sides: m, shape (3,).
        coefficients: Of the faces square to x, y and z, shape (3,).

    Returns:
        q per unit density: three along the axes, m2, and three about them, m5; shape
        (6,); force_i = -rho q_i v_i |v_i|.

    Raises:
        RobotError: A side is not positive, or a coefficient negative.
    """
    where = "morph.physics.fluid.wetted.box_drag"
    length = np.asarray(sides, dtype=np.float64)
    drag = np.asarray(coefficients, dtype=np.float64)
    if not (np.isfinite(length).all() and (length > 0).all()):
        raise RobotError(
            f"its sides are {length.tolist()} m", where=where, fix="give three sides above 0"
        )
    for value in drag.tolist():
        _check("coefficient", value, where)
    along = [0.5 * drag[i] * length[(i + 1) % 3] * length[(i + 2) % 3] for i in range(3)]
    about = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        about.append(length[i] * (drag[j] * length[k] ** 4 + drag[k] * length[j] ** 4) / 64.0)
    return np.array(along + about)


def slow_drag(volume: float, *, viscosity: float = WATER_VISCOSITY) -> Array:
    """Return the linear drag of the ball of a volume in creeping flow, shape (6,).

    6 pi mu r along and 8 pi mu r^3 about each axis (Lamb 1932, arts. 338 and 334). It is
    the least that a body of this volume can have, and matters below Reynolds numbers of
    about 20: there 24/Re, Stokes' coefficient, exceeds the bluff 1.1. At what robots
    swim it is nothing beside `panel_drag`, so that 0 is a sensible default.

    Args:
        volume: m3.
        viscosity: mu, Pa s.

    Returns:
        Three along the axes, N s/m, and three about them, N m s/rad.

    Raises:
        RobotError: The volume or the viscosity is negative or not finite.
    """
    _check("volume", volume, "morph.physics.fluid.wetted.slow_drag")
    _check("viscosity", viscosity, "morph.physics.fluid.wetted.slow_drag")
    radius = (3.0 * volume / (4.0 * math.pi)) ** (1.0 / 3.0)
    along, about = 6.0 * math.pi * viscosity * radius, 8.0 * math.pi * viscosity * radius**3
    return np.array([along] * 3 + [about] * 3)


def _check(what: str, value: float, where: str) -> None:
    if not (math.isfinite(value) and value >= 0.0):
        raise RobotError(
            f"the {what} is {value:g}", where=where, fix="give a finite number, 0 or more"
        )
