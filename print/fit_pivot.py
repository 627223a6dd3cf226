"""How two parts turn about an axle: a lap joint, a bearing in one part, a screw in the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.bearing import BEARINGS, bearing, seat
from morph.print.errors import SeatError
from morph.print.fitting import Fitting
from morph.print.mesh import from_manifold
from morph.print.part import Seat
from morph.print.printer import Profile
from morph.print.screw import SCREWS, Screw, screw
from morph.print.skeleton import Pivot
from morph.print.solid import frame, placed, rod, union

GAP_MM = 0.6
"""Between the two parts of a lap joint; each keeps half of it."""

BOSS_MM = 4.0
"""Least thickness of what holds an axle."""

WALL_MM = 2.4
"""Around a bearing, and around the hole of a screw."""

FREE_MM = 0.5
"""Room around a boss in the other part."""

FLOOR_MM = 1.2
"""What a bearing rests on."""

DEEP_MM = 12.0
"""How deep an axle's screw goes at most."""


@dataclass(frozen=True, kw_only=True)
class Axle:
    """What turns in a pivot."""

    screw: Screw
    """The screw that is the axle."""
    outer_mm: float
    """Diameter of the hole on the side of the bearing, or of the screw's head."""
    seat_mm: float
    """Depth of the bearing's seat; 0 without a bearing."""

    @property
    def radius_mm(self) -> float:
        """Radius of the boss of both parts."""
        return self.outer_mm / 2 + WALL_MM

    @property
    def thick_mm(self) -> float:
        """Thickness of the boss that holds a bearing."""
        return max(BOSS_MM, self.seat_mm + FLOOR_MM)


def axle(name: str) -> Axle:
    """Return the axle of a pivot, by the name of its bearing or of its screw.

    Raises:
        SeatError: There is neither a bearing nor a screw of this name.
    """
    if any(known.name.lower() == name.lower() for known in BEARINGS):
        which = bearing(name)
        return Axle(screw=screw(which.screw), outer_mm=which.outer_mm, seat_mm=which.width_mm)
    if any(known.name.lower() == name.lower() for known in SCREWS):
        result = screw(name)
        return Axle(screw=result, outer_mm=result.clear_mm, seat_mm=0.0)
    raise SeatError(
        f"no bearing and no screw is called {name[:100]!r}",
        where="morph.print.skeleton.Pivot.bearing",
        fix=f"name one of {', '.join(each.name for each in (*BEARINGS, *SCREWS))}",
    )


def pivot(which: Pivot, beside: Sequence[Pivot], far_mm: float, profile: Profile) -> Fitting:
    """Return one part's half of a lap joint.

    Args:
        which: The joint.
        beside: The part's other joints without a servo: half of the way to them is theirs.
        far_mm: A length greater than the part: how far its other half is cleared otherwise.
        profile: How much play a bearing has.
    """
    about = axle(which.bearing)
    # In this frame the part is above z = 0, whichever side it is on.
    up = float(which.side) * np.asarray(which.axis, dtype=np.float64)
    pose = frame(which.position, up)
    start = GAP_MM / 2
    boss = rod(about.radius_mm, start, start + about.thick_mm)
    below, above = _reach(pose, about, beside, far_mm)
    other_half = rod(about.radius_mm + FREE_MM, -below, start)
    holes = _bearing_hole(about, start, above, profile) if which.side < 0 else _screw_hole(about)
    return Fitting(
        name=f"the boss of a pivot on {about.screw.name}",
        added=(placed(boss, pose),),
        removed=(placed(other_half, pose), placed(holes, pose)),
        seats=(_seat(which, about, pose, start, profile),),
    )


def _reach(pose: Array, about: Axle, beside: Sequence[Pivot], far: float) -> tuple[float, float]:
    """Return how far along the axis, against it and with it, no other joint's axle is."""
    back = np.linalg.inv(pose)
    below = above = far
    for other in beside:
        x, y, z = (back @ np.append(other.position, 1.0))[:3]
        if np.hypot(x, y) < about.radius_mm + axle(other.bearing).radius_mm:
            below = min(below, -z / 2.0) if z < 0.0 else below
            above = min(above, z / 2.0) if z > 0.0 else above
    return max(below, about.thick_mm), max(above, 2.0 * about.thick_mm)


def _bearing_hole(about: Axle, start: float, far: float, profile: Profile) -> Any:
    """Return the seat of a bearing, open to the other part, and the way for its screw."""
    through = rod(about.screw.clear_mm / 2, 0.0, start + about.thick_mm + 0.1)
    head = rod(about.screw.head_mm / 2 + 0.3, start + about.thick_mm, far)
    if about.seat_mm == 0.0:
        return union([through, head])
    radius = about.outer_mm / 2 + profile.clearance_mm / 2
    return union([rod(radius, 0.0, start + about.seat_mm), through, head])


def _screw_hole(about: Axle) -> Any:
    """Return the hole that the axle's screw cuts its thread into."""
    return rod(about.screw.tap_mm / 2, 0.0, GAP_MM / 2 + DEEP_MM)


def _seat(which: Pivot, about: Axle, pose: Array, start: float, profile: Profile) -> Seat:
    at = (pose @ np.array([0.0, 0.0, start, 1.0]))[:3]
    if which.side > 0:
        return Seat(
            holds=about.screw.name, position=at, axis=-pose[:3, 2], bore_mm=about.screw.tap_mm
        )
    if about.seat_mm == 0.0:
        return Seat(
            holds=about.screw.name, position=at, axis=-pose[:3, 2], bore_mm=about.screw.clear_mm
        )
    play = profile.clearance_mm / 2
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[2, 3] = start
    room = placed(seat(bearing(which.bearing), play).manifold, pose @ down)
    return Seat(
        holds=bearing(which.bearing).name,
        position=at,
        axis=-pose[:3, 2],
        bore_mm=about.outer_mm + 2.0 * play,
        pocket=from_manifold(room),
    )
