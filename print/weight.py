"""How heavy something is and where: mass, centre of mass and inertia, in SI units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array

MM = 1e-3
"""One millimetre, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Weight:
    """A rigid body's mass and how it is spread, in the frame of the part that it belongs to."""

    mass: float
    """kg."""
    com: Array
    """Centre of mass, m, shape (3,)."""
    inertia: Array
    """About the centre of mass, kg m2, shape (3, 3)."""

    def moved(self, pose: Array) -> Weight:
        """Return it under a transform, shape (4, 4), whose translation is in mm.

        A mirror is allowed: R I R' holds for any orthogonal R.
        """
        turn = pose[:3, :3]
        return Weight(
            mass=self.mass,
            com=turn @ self.com + pose[:3, 3] * MM,
            inertia=turn @ self.inertia @ turn.T,
        )

    def scaled(self, mass: float) -> Weight:
        """Return the same spread with another mass, kg: I is proportional to the density."""
        return Weight(mass=mass, com=self.com, inertia=self.inertia * (mass / self.mass))


def together(weights: Iterable[Weight]) -> Weight:
    """Return several weights in one frame as one, by Steiner's theorem; nothing weighs nothing."""
    parts = [part for part in weights if part.mass > 0]
    mass = sum(part.mass for part in parts)
    if not parts:
        return Weight(mass=0.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    com = sum((part.mass * part.com for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        away = part.com - com
        inertia += part.inertia + part.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return Weight(mass=mass, com=com, inertia=inertia)


def box(mass: float, size_mm: Array) -> Weight:
    """Return a uniform box about its middle: I = m / 12 (b2 + c2) about the axis of length a."""
    square = (np.asarray(size_mm, dtype=np.float64) * MM) ** 2
    return Weight(
        mass=mass, com=np.zeros(3), inertia=np.diag(mass / 12.0 * (square.sum() - square))
    )
