"""How a part holds a servo, and how it is screwed to the horn of another part's servo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from morph.print.fitting import Fitting
from morph.print.mesh import from_manifold
from morph.print.part import Seat
from morph.print.printer import Profile
from morph.print.screw import screw
from morph.print.servo import (
    FREE_MM,
    ServoSize,
    Side,
    case,
    horn_disc,
    horn_pattern,
    horn_reach,
    screw_holes,
    servo,
    turning_room,
    way_in,
    wire_room,
)
from morph.print.skeleton import Mount
from morph.print.solid import box, placed, rod, union

WALL_MM = 2.4
"""Wall and floor of a pocket: at least five lines of a nozzle of 0.4 mm."""

UNDER_MM = 8.0
"""How far before a horn a part that it turns has nothing: there is the servo."""

FACETS = 0.9
"""Of the play, what a seat promises: facets and rounding take the rest."""

CROWDED_MM3 = 50.0
"""Room that two servos may share, as drawings round their sizes."""

SIDES: tuple[Side, ...] = ("+z", "+y", "-y")
"""Where a pocket may be open, the one that holds best first."""


def pockets(mounts: Sequence[Mount], body: Any, profile: Profile) -> tuple[Fitting, ...]:
    """Return the pockets of servos in a part, each open to the side that costs least plastic.

    Args:
        mounts: The servos.
        body: What else the part is made of, as a solid; it may be empty.
        profile: How much play there is.
    """
    walls = [placed(_walls(servo(m.servo), profile.clearance_mm), m.pose) for m in mounts]
    results = []
    for k, mount in enumerate(mounts):
        others = union([body, *(wall for j, wall in enumerate(walls) if j != k)])
        fitting = _pocket(mount, walls[k], others, profile)
        results.append(replace(fitting, notes=(*fitting.notes, *_crowded(mounts, k))))
    return tuple(results)


def _crowded(mounts: Sequence[Mount], k: int) -> list[str]:
    """Return what to say of servos that are drawn where another one is, each pair once."""
    mine = placed(case(servo(mounts[k].servo)).manifold, mounts[k].pose)
    lines = []
    for other in mounts[:k]:
        both = float((placed(case(servo(other.servo)).manifold, other.pose) ^ mine).volume())
        if both > CROWDED_MM3:
            names = f"a {other.servo} and a {mounts[k].servo}"
            lines.append(f"{names} are drawn into each other by {both / 1e3:.1f} cm3: move one")
    return lines


def _pocket(mount: Mount, walls: Any, others: Any, profile: Profile) -> Fitting:
    which, play = servo(mount.servo), profile.clearance_mm
    ways = {side: placed(way_in(which, play, side), mount.pose) for side in SIDES}
    cost = {side: float((way ^ others).volume()) for side, way in ways.items()}
    # A tenth more plastic is no reason to leave the side from which screws and horn are reached.
    side = min(SIDES, key=lambda each: cost[each] + (0.0 if each == "+z" else 0.1 * cost["+z"] + 1))
    rest = [placed(turning_room(which), mount.pose), placed(wire_room(which, play), mount.pose)]
    holes = screw_holes(which, WALL_MM + play)
    empty = union([ways[side], *rest])
    promised = union([placed(way_in(which, FACETS * play, side), mount.pose), *rest])
    seat = Seat(
        holds=which.name,
        position=mount.pose[:3, 3],
        axis=mount.pose[:3, 2],
        bore_mm=0.0,
        pocket=from_manifold(promised),
    )
    return Fitting(
        name=f"the pocket of a {which.name}",
        added=(walls,),
        removed=(empty, *(() if holes is None else (placed(holes.manifold, mount.pose),))),
        seats=(seat, *_screws(which, mount, play)),
        notes=() if which.holes_mm else (_strapped(which),),
    )


def _strapped(which: ServoSize) -> str:
    return f"which screws hold an {which.name} is not known here: a strap round its pocket does"


def _walls(which: ServoSize, play: float) -> Any:
    """Return the block around a case, up to its top or to the underside of its flange."""
    grow = play + WALL_MM
    near, far = -which.axis_mm - grow, which.length_mm - which.axis_mm + grow
    half, low, high = which.width_mm / 2 + grow, -which.height_mm - grow, 0.0
    if which.flange is not None:
        middle = which.length_mm / 2 - which.axis_mm
        reach = which.flange.length_mm / 2 + play
        near, far, high = middle - reach, middle + reach, -which.flange.depth_mm
    return box((near, -half, low), (far, half, high))


def _screws(which: ServoSize, mount: Mount, play: float) -> tuple[Seat, ...]:
    """Return the seats of the screws that hold a servo."""
    size = screw(which.hole_screw)
    rim = which.held_by == "rim" and which.flange is not None
    # The mouth of a hole: on the rim, or where its head lies under the floor.
    height = -which.height_mm - play - WALL_MM
    if rim and which.flange is not None:
        height = -which.flange.depth_mm
    results = []
    for x, y in which.holes_mm:
        at = mount.pose @ np.array([x, y, height, 1.0])
        results.append(
            Seat(
                holds=size.name,
                position=at[:3],
                axis=mount.pose[:3, 2] * (1.0 if rim else -1.0),
                bore_mm=size.tap_mm if rim else size.clear_mm,
            )
        )
    return tuple(results)


def horn(mount: Mount, profile: Profile) -> Fitting:
    """Return the disc by which a part is screwed to a servo's horn."""
    which = servo(mount.servo)
    pattern = placed(horn_pattern(which, profile.clearance_mm).manifold, mount.pose)
    # What the part has between the disc and the servo would rub on the case.
    reach = which.horn.diameter_mm / 2 + FREE_MM
    rub = placed(rod(reach, -UNDER_MM, which.horn.top_mm), mount.pose)
    seat = Seat(
        holds=f"{which.name} horn",
        position=(mount.pose @ np.array([0.0, 0.0, which.horn.top_mm, 1.0]))[:3],
        axis=-mount.pose[:3, 2],
        bore_mm=which.horn.centre_mm,
        pocket=from_manifold(pattern),
    )
    return Fitting(
        name=f"the disc on the horn of a {which.name}",
        added=(placed(horn_disc(which), mount.pose),),
        removed=(pattern, placed(horn_reach(which), mount.pose), rub),
        seats=(seat,),
    )
