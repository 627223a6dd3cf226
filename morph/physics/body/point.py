"""Effects that act at one point of a link."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.physics.kinds import BodyEffect
from morph.physics.motion import Motion

REACHES = (1.0, 1.5, 2.0)
"""Distances of points to try from the link's origin, as shares of that of its centre of mass. Drag
on a rod that turns about its end has its centre at 4/3 of that distance, quadratic drag at 3/2, and
the rod ends at 2."""


class PointEffect(BodyEffect):
    """An effect at a point of a link, given in the link's frame."""

    cx: float
    cy: float
    cz: float

    @property
    def centre(self) -> Array:
        """The point at which it acts, in the link's frame, m, shape (3,)."""
        return np.array([self.cx, self.cy, self.cz])

    def shapes(self, motion: Motion) -> tuple[PointEffect, ...]:
        """Return the effect at points between the link's middle and its end.

        A point that is known, other than the link's origin, stays as it is. The origin lies on a
        joint, where a force moves the link least.
        """
        return tuple(replace(self, **at) for at in points_of(self, motion))  # type: ignore[type-var]


def points_of(effect: PointEffect, motion: Motion) -> list[dict[str, float]]:
    """Return the points at which an effect may act on its link, as its parameters."""
    com = motion.bodies[effect.body].com
    if effect.centre.any() or not com.any():
        return [{}]
    return [dict(zip(("cx", "cy", "cz"), (share * com).tolist(), strict=True)) for share in REACHES]
