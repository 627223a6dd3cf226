"""Boundary elements against Lamb's closed form, with the seconds that a link costs."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.physics.fluid.tensor import ellipsoid_tensor, extrapolated, kirchhoff

SHAPES = ((0.3, 0.2, 0.1), (0.5, 0.1, 0.1), (0.3, 0.3, 0.2), (0.15, 0.1, 0.07), (0.2, 0.2, 0.05))
"""Semi-axes of the ellipsoids, m."""

STILL = 1e-12
"""What Lamb's tensor holds where a spheroid turns about its axis: nothing."""


@dataclass(frozen=True, kw_only=True)
class Accuracy:
    """Boundary elements on one ellipsoid, relative errors of the worst diagonal entry."""

    radii: tuple[float, float, float]
    """Its semi-axes, m."""
    linear: float
    """Along its axes, at 1280 panels."""
    rotational: float
    """About its axes, where Lamb's is not 0, at 1280 panels."""
    linear_extrapolated: float
    """Along its axes, from 320 and 1280 panels."""
    rotational_extrapolated: float
    """About them."""
    linear_twice: float
    """Along its axes, from 80, 320 and 1280 panels: extrapolated again, at fourth order."""
    rotational_twice: float
    """About them."""
    seconds: float
    """Of processor time for all three."""


def accuracy(radii: tuple[float, float, float]) -> Accuracy:
    """Return how far boundary elements are from Lamb's tensor of an ellipsoid."""
    truth = np.diag(ellipsoid_tensor(*radii).matrix)
    began = time.process_time()
    coarse, middle, fine = (np.diag(kirchhoff(*_ellipsoid(radii, times))) for times in (1, 2, 3))
    limit = extrapolated(middle, fine)
    twice = extrapolated(extrapolated(coarse, middle), limit, order=4.0)
    seconds = time.process_time() - began
    return Accuracy(
        radii=radii,
        linear=_worst(fine[:3], truth[:3]),
        rotational=_worst(fine[3:], truth[3:]),
        linear_extrapolated=_worst(limit[:3], truth[:3]),
        rotational_extrapolated=_worst(limit[3:], truth[3:]),
        linear_twice=_worst(twice[:3], truth[:3]),
        rotational_twice=_worst(twice[3:], truth[3:]),
        seconds=seconds,
    )


def _ellipsoid(radii: tuple[float, float, float], times: int) -> tuple[Array, Integers]:
    """Return an icosahedron whose faces were quartered so many times, blown up to an ellipsoid."""
    # Loads a library that only this needs.
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=times)
    return np.asarray(ball.vertices * radii), np.asarray(ball.faces, dtype=np.int64)


def _worst(found: Array, truth: Array) -> float:
    there = truth > STILL
    return float(np.abs(found[there] / truth[there] - 1.0).max()) if there.any() else 0.0
