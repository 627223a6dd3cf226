"""What constant panels of potential and of flux cause at points on the surface."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.physics.fluid.tensor.panels import Panels

ROOM = 100_000
"""Pairs of a point and a panel that are worked on at once; each array of them takes 0.8 MB."""

FLAT = 1e-12
"""Height above a panel's plane, as a part of the surface's size, that counts as none."""


def influence(points: Array, panels: Panels, flux: Array) -> tuple[Array, Array]:
    """Return the double layer of each panel, and the single layer of all, at points.

    With r the distance from a point x to a place y on a panel, n the panel's
    normal, and W the solid angle under which x sees the panel from within:

        double = integral of (y - x) . n / (4 pi r^3) dS = W / (4 pi)
        single = integral of flux / (4 pi r) dS

    Sources: W by Van Oosterom and Strackee 1983, IEEE Trans. Biomed. Eng. 30(2),
    eq. 8; the integral of 1/r by Wilton et al. 1984, IEEE Trans. Antennas Propag.
    32(3), eq. 5. Both are exact. In a panel's own plane W is 0, its mean from both sides.

    Args:
        points: Places, shape (k, 3), m.
        panels: The surface, m panels.
        flux: Normal velocities, constant on each panel, shape (m, j).

    Returns:
        The double layer, shape (k, m), and the single layer, shape (k, j).
    """
    double = np.empty((len(points), len(panels)))
    single = np.empty((len(points), flux.shape[1]))
    step = max(1, ROOM // len(panels))
    for start in range(0, len(points), step):
        rows = slice(start, start + step)
        double[rows], reach = _pairs(points[rows], panels)
        single[rows] = reach @ flux
    double /= 4.0 * np.pi
    single /= 4.0 * np.pi
    return double, single


def _pairs(points: Array, panels: Panels) -> tuple[Array, Array]:
    """Return the solid angle and the integral of 1/r of each panel, shapes (k, m)."""
    corners, normals = panels.corners, panels.normals
    distances = [_distances(points, corners[:, at]) for at in range(3)]
    edges = [corners[:, (at + 1) % 3] - corners[:, at] for at in range(3)]
    lengths = [np.linalg.norm(edge, axis=1) for edge in edges]
    height = np.einsum("ij,ij->i", normals, corners[:, 0]) - points @ normals.T
    height[np.abs(height) < FLAT * np.ptp(corners, axis=(0, 1)).max()] = 0.0
    angle = _solid_angle(distances, lengths, 2.0 * panels.areas * height)
    reach = -height * angle
    for at in range(3):
        out = np.cross(edges[at], normals) / lengths[at][:, None]
        away = np.einsum("ij,ij->i", out, corners[:, at]) - points @ out.T
        both = distances[at] + distances[(at + 1) % 3]
        # On the edge itself the logarithm is infinite, and its weight `away` zero.
        gap = np.maximum(both - lengths[at], 1e-15 * lengths[at])
        reach += away * np.log((both + lengths[at]) / gap)
    return angle, reach


def _distances(points: Array, others: Array) -> Array:
    # Coordinate by coordinate: half the time of a norm over the last axis.
    squared = np.zeros((len(points), len(others)))
    for axis in range(3):
        squared += np.square(points[:, axis, None] - others[:, axis])
    return np.sqrt(squared, out=squared)


def _solid_angle(distances: list[Array], lengths: list[Array], volume: Array) -> Array:
    """Return solid angles from the distances to three corners; `volume` is their determinant."""
    a, b, c = distances
    squares = [distance**2 for distance in distances]
    # a . b = (a^2 + b^2 - |a - b|^2) / 2, and so round the triangle.
    below = a * b * c
    for at, other in enumerate((c, a, b)):
        below += 0.5 * (squares[at] + squares[(at + 1) % 3] - lengths[at] ** 2) * other
    angle: Array = 2.0 * np.arctan2(volume, below)
    angle[volume == 0.0] = 0.0
    return angle
