"""Whether parts collide where joints move them: intersections along each joint's range."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from print.arrays import Array
from print.errors import SolidError
from print.part import Check, Hinge, Part
from print.printer import Profile
from print.solid import frame

NAME = "clearance"
TOUCH_MM3 = 1.0
"""Volume of two parts in each other that counts as touching: facets and rounding."""
FILM_MM = 0.1
"""Two parts in each other by a film thinner than this touch, however large it is: a round pin in
a round hole of its own size, both of facets."""
STEP_MM = 4.0
"""Furthest that a point moves between two positions that are looked at."""
MOST_STEPS = 48
"""Most positions of one joint."""
BLOCKED = 0.05
"""More of the range than this beyond a collision refuses the joint."""
INSIDE = 0.01
"""Most of a printed part that may lie in another before anything moves."""
COARSE_MM = 0.05
"""How far surfaces may be moved to have fewer triangles to look at."""
FAR = 1e6
"""An unlimited joint has a range beyond this; what is looked at is one turn, or nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """The solids of one link, in the world with all joints at zero."""

    solids: tuple[tuple[str, Any], ...]
    """Each part's name and its `manifold3d.Manifold`."""
    printed: dict[str, float]
    """Volume of each part that is printed, mm3, by its name."""
    unknown: tuple[str, ...]
    """Parts that are no solid and so are left out."""


def clearances(
    parts: Sequence[Part], hinges: Sequence[Hinge], profile: Profile
) -> tuple[Check, ...]:
    """Return for each joint whether its two links stay clear of each other along its range.

    The parts of the moving link, printed and bought, are carried along the joint in steps of at
    most `STEP_MM`, and intersected with those of the link that stays. Links further along the
    tree are left out, as are two links that no joint connects. Parts that lie in each other
    where nothing has moved, such as a horn on its spline, count as in the way only where they
    lie in each other by more than there.

    Args:
        parts: With their placements in the world, all joints at zero.
        hinges: The joints.
        profile: How it is printed; not used yet, since play is in the parts already.
    """
    del profile
    groups: dict[str, Group] = {}
    for link in {name for hinge in hinges for name in (hinge.still, hinge.moving)}:
        groups[link] = _group(parts, link)
    return tuple(_clearance(hinge, groups[hinge.still], groups[hinge.moving]) for hinge in hinges)


def _group(parts: Sequence[Part], link: str) -> Group:
    solids, unknown, printed = [], [], {}
    for part in parts:
        for placement in part.placements:
            if placement.link != link or part.kind == "fused":
                continue
            try:
                if part.mesh is None:
                    continue
                solid = part.mesh.moved(placement.world).manifold.simplify(COARSE_MM)
                solids.append((part.name, solid))
                if part.kind == "printed":
                    printed[part.name] = float(solid.volume())
            except SolidError:
                unknown.append(part.name)
    return Group(solids=tuple(solids), printed=printed, unknown=tuple(unknown))


def _clearance(hinge: Hinge, still: Group, moving: Group) -> Check:
    left_out = sorted({*still.unknown, *moving.unknown})
    note = f"; without {', '.join(left_out)}, no solid" if left_out else ""
    if not still.solids or not moving.solids:
        what = f"nothing to look at: {hinge.still} or {hinge.moving} has no solid part{note}"
        return _says(hinge, "passed" if not left_out else "noted", what)
    sweep = _Sweep(hinge, still, moving)
    for (one, other), volume in sweep.rest.items():
        both = [
            side[name]
            for side, name in ((still.printed, one), (moving.printed, other))
            if name in side
        ]
        if volume > TOUCH_MM3 and len(both) == 2 and volume > INSIDE * min(both):
            what = f"{other} and {one} lie in each other by {volume:.3g} mm3 before anything moves"
            return _says(hinge, "refused", what, "move them apart, or join them into one part")
    return _judged(hinge, sweep, note)


def _says(
    hinge: Hinge,
    verdict: Literal["passed", "noted", "refused"],
    what: str,
    fix: str = "",
    value: float | None = None,
) -> Check:
    limit = None if value is None else BLOCKED
    return Check(
        part=hinge.name, name=NAME, verdict=verdict, what=what, fix=fix, value=value, limit=limit
    )


class _Sweep:
    """Positions of one joint, and how much of its links lies in each other at each."""

    def __init__(self, hinge: Hinge, still: Group, moving: Group) -> None:
        self.hinge = hinge
        self.low, self.high = _range(hinge)
        self.start = min(max(0.0, self.low), self.high)
        self.frame = frame(hinge.position, hinge.axis)
        # In the joint's frame z is its axis: turning is about it, sliding along it.
        into = np.asarray(np.linalg.inv(self.frame), dtype=np.float64)
        self.still = [(name, _placed(solid, into)) for name, solid in still.solids]
        self.moving = [(name, _placed(solid, into)) for name, solid in moving.solids]
        self._crop()
        self.radius = max((_radius(solid) for _, solid in self.moving), default=0.0)
        self.rest = self.shared(self.start)

    def _crop(self) -> None:
        """Leave of either side only what the other can reach."""
        from print.solid import rod

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
        found: dict[tuple[str, str], float] = {}
        for still, solid in self.still:
            for moving, other in moved:
                if _apart(solid, other):
                    continue
                volume = _overlap(solid ^ other)
                if volume > 0:
                    found[still, moving] = found.get((still, moving), 0.0) + volume
        return found

    def hit(self, position: float) -> tuple[tuple[str, str], float] | None:
        """Return the pair that is most in each other's way at a position, and its volume."""
        found = {
            pair: volume
            for pair, volume in self.shared(position).items()
            if volume > 1.05 * self.rest.get(pair, 0.0) + TOUCH_MM3
        }
        pair = max(found, key=lambda each: found[each], default=None)
        return None if pair is None else (pair, found[pair])

    def free_to(self, to: float) -> tuple[float, tuple[tuple[str, str], float] | None]:
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


def _judged(hinge: Hinge, sweep: _Sweep, note: str) -> Check:
    below, under = sweep.free_to(sweep.low)
    above, over = sweep.free_to(sweep.high)
    span = max(sweep.high - sweep.low, 1e-9)
    blocked = 1.0 - (above - below) / span
    met = under or over
    rest = {pair: volume for pair, volume in sweep.rest.items() if volume > TOUCH_MM3}
    if rest:
        (still, moving), volume = max(rest.items(), key=lambda each: each[1])
        note = f"; {moving} and {still} share {volume:.3g} mm3 before anything moves{note}"
    whole = f"{_told(hinge, sweep.low)} to {_told(hinge, sweep.high)}"
    if met is None:
        verdict: Literal["passed", "noted"] = "noted" if note else "passed"
        return _says(hinge, verdict, f"free from {whole}{note}", value=0.0)
    (still, moving), volume = met
    at = below if under else above
    what = (
        f"{moving} meets {still} at {_told(hinge, at)} ({volume:.3g} mm3); free from "
        f"{_told(hinge, below)} to {_told(hinge, above)} of {whole}{note}"
    )
    fix = "limit the joint to the range that is free, or move the parts apart"
    return _says(hinge, "refused" if blocked > BLOCKED else "noted", what, fix, value=blocked)


def _range(hinge: Hinge) -> tuple[float, float]:
    """Return the range that is looked at: a turn at most, nothing of a slide without limits."""
    low, high = hinge.low, hinge.high
    if hinge.kind == "hinge" and not (np.isfinite([low, high]).all() and high - low < 2 * math.pi):
        return -math.pi, math.pi
    if not np.isfinite([low, high]).all() or high - low > FAR:
        return 0.0, 0.0
    return min(low, high), max(low, high)


def _told(hinge: Hinge, position: float) -> str:
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
