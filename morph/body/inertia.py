"""What a rigid body's inertia must satisfy, and the nearest that does."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array

DENSITY = 1000.0
"""Density assumed where a description gives a shape and no mass, kg/m3: that of water."""

ROUNDING = 1e-12
"""Relative slack of the triangle inequality: that of sums of doubles, with room."""

THINNEST = 1e-4
"""Least second moment of a mended inertia, as a part of its greatest."""


def spread(inertia: Array) -> Array:
    """Return the second moments of mass, tr(I)/2 1 - I, shape (3, 3).

    They are the integral of x x' dm, which no mass distribution makes negative;
    so I belongs to a body exactly if they are positive semidefinite, which is
    the triangle inequality of its principal moments (Wensing, Kim and Slotine
    2018, IEEE RA-L 3(1), eq. 13).
    """
    moments: Array = np.trace(inertia) / 2 * np.eye(3) - inertia
    return moments


def is_physical(inertia: Array) -> bool:
    """Return whether some body has this inertia, shape (3, 3), up to rounding."""
    if not np.isfinite(inertia).all():
        return False
    moments = np.linalg.eigvalsh(spread(inertia))
    return bool(moments[0] >= -ROUNDING * max(moments[2], 0.0) and moments[2] > 0)


def mended(inertia: Array) -> Array | None:
    """Return the nearest physical inertia, with its axes kept; None if there is no way.

    Negative second moments are raised to a small positive one, so the result
    is the nearest in the Frobenius norm of the second moments (Higham 1988).
    """
    if not np.isfinite(inertia).all():
        return None
    moments, axes = np.linalg.eigh(spread(inertia))
    if moments[2] <= 0:
        return None
    moments = np.maximum(moments, THINNEST * moments[2])
    raised = axes @ np.diag(moments) @ axes.T
    repaired: Array = np.trace(raised) * np.eye(3) - raised
    return (repaired + repaired.T) / 2


def ball(mass: float, density: float) -> Array:
    """Return the inertia of a solid ball, 2/5 m r^2, shape (3, 3)."""
    radius = (3 * mass / (4 * np.pi * density)) ** (1 / 3)
    about: Array = np.eye(3) * 0.4 * mass * radius**2
    return about
