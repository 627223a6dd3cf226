"""One joint moved along its range, and which solids of its two links are then in each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.part import Hinge
from morph.print.solid import frame

TOUCH_MM3 = 1.0
"""Volume of two parts in each other that counts as touching: facets and rounding."""
FILM_MM = 0.1
"""Two parts in each other by a film thinner than this touch, however large it is: a round pin in
a round hole of its own size, both of facets."""
STEP_MM = 4.0
"""Furthest that a point moves between two positions that are looked at."""
MOST_STEPS = 48
"""Most positions of one joint."""
FAR = 1e6
"""An unlimited joint has a range beyond this; what is looked at is one turn, or nothing."""

Named = tuple[str, Any]
"""A part's name and its `manifold3d.Manifold` in the world, all joints at zero."""

Met = tuple[tuple[str, str], float]
"""Which two are in each other, that which stays first, and by how much, mm3."""


class Sweep:
    """Positions of one joint, and how much of its links lies in each other at each."""

    def __init__(self, hinge: Hinge, still: Sequence[Named], moving: Sequence[Named]) -> None:
        self.hinge = hinge
        self.low, self.high = _range(hinge)
        self.start = min(max(0.0, self.low), self.high)
        self.frame = frame(hinge.position, hinge.axis)
        # In the joint's frame z is its axis: turning is about it, sliding along it.
        into = np.asarray(np.linalg.inv(self.frame), dtype=np.float64)
        self.still = [(name, _placed(solid, into)) for name, solid in still]
        self.moving = [(name, _placed(solid, into)) for name, solid in moving]
        self._crop()
        self.radius = max((_radius(solid) for _, solid in self.moving), default=0.0)
        self.rest = self.shared(self.start)

    def _crop(self) -> None:
        """Leave of either side only what the other can reach."""
        from morph.print.solid import rod

        if self.hinge.kind == "slide":
            return
        for mine, other in (("still", "moving"), ("moving", "still")):
            solids = getattr(self, other)
            if not solids:
                return
            boxes = np.array([solid.bounding_box() for _, solid in solids])
            reach = max(_radius(solid) for _, solid in solids) + 1.0
            tin = rod(reach / math.cos(math.pi / 24), boxes[:, 2].min() - 1, boxes[:, 5].max() + 1)
            kept = [(name, solid ^ tin) for name, solid in getattr(self, mine)]
            setattr(self, mine, [(name, solid) for name, solid in kept if not solid.is_empty()])

    def positions(self, to: float) -> Array:
        """Return positions from the start to an end, the start left out."""
        span = to - self.start
        travel = abs(span) * (self.radius if self.hinge.kind == "hinge" else 1.0)
        share = abs(span) / max(self.high - self.low, 1e-9)
        count = min(math.ceil(travel / STEP_MM), max(math.ceil(MOST_STEPS * share), 1))
        return np.linspace(self.start, to, count + 1)[1:]

    def shared(self, position: float) -> dict[tuple[str, str], float]:
        """Return the volume that each pair of parts shares at a position, mm3."""
        if self.hinge.kind == "hinge":
            moved = [(n, s.rotate((0, 0, math.degrees(position)))) for n, s in self.moving]
        else:
            moved = [(n, s.translate((0, 0, position))) for n, s in self.moving]
        results: dict[tuple[str, str], float] = {}
        for still, solid in self.still:
            for moving, other in moved:
                if _apart(solid, other):
                    continue
                volume = _overlap(solid ^ other)
                if volume > 0:
                    results[still, moving] = results.get((still, moving), 0.0) + volume
        return results

    def hit(self, position: float) -> Met | None:
        """Return the pair that is most in each other's way at a position, and its volume."""
        results = {
            pair: volume
            for pair, volume in self.shared(position).items()
            if volume > 1.05 * self.rest.get(pair, 0.0) + TOUCH_MM3
        }
        pair = max(results, key=lambda each: results[each], default=None)
        return None if pair is None else (pair, results[pair])

    def free_to(self, to: float) -> tuple[float, Met | None]:
        """Return how far the joint moves freely from its start, and what it meets there."""
        free = self.start
        for position in self.positions(to):
            met = self.hit(float(position))
            if met is None:
                free = float(position)
                continue
            taken = float(position)
            for _ in range(4):
                middle = (free + taken) / 2.0
                nearer = self.hit(middle)
                free, taken, met = (
                    (middle, taken, met) if nearer is None else (free, middle, nearer)
                )
            return free, met
        return to, None


def _range(hinge: Hinge) -> tuple[float, float]:
    """Return the range that is looked at: a turn at most, nothing of a slide without limits."""
    low, high = hinge.low, hinge.high
    if hinge.kind == "hinge" and not (np.isfinite([low, high]).all() and high - low < 2 * math.pi):
        return -math.pi, math.pi
    if not np.isfinite([low, high]).all() or high - low > FAR:
        return 0.0, 0.0
    return min(low, high), max(low, high)


def told(hinge: Hinge, position: float) -> str:
    """Return a joint's position in words."""
    if hinge.kind == "slide":
        return f"{position:.1f} mm"
    return f"{math.degrees(position):.1f} deg"


def _placed(solid: Any, pose: Array) -> Any:
    return solid.transform(np.ascontiguousarray(pose[:3, :4]))


def _radius(solid: Any) -> float:
    """Return how far the furthest corner is from the axis, mm."""
    corners = np.asarray(solid.to_mesh64().vert_properties)[:, :2]
    return float(np.linalg.norm(corners, axis=1).max()) if len(corners) else 0.0


def _overlap(both: Any) -> float:
    """Return the volume of an intersection, mm3, or 0 of a film.

    A film of thickness t and area A has the volume t A and a surface of 2 A.
    """
    volume = float(both.volume())
    if volume > TOUCH_MM3 and 2.0 * volume < FILM_MM * float(both.surface_area()):
        return 0.0
    return volume


def _apart(one: Any, other: Any) -> bool:
    """Return whether two solids' boxes are apart."""
    a, b = np.array(one.bounding_box()), np.array(other.bounding_box())
    return bool((a[3:] <= b[:3]).any() or (b[3:] <= a[:3]).any())
