"""Servos by name, and what is cut, added and drawn for them, in the servo's own frame.

The origin is where the axis leaves the case; z points out of the case along the axis, and x
along the case towards its far end.
"""

from __future__ import annotations

import difflib
import math
from typing import Any, Literal

import numpy as np

from morph.print.errors import SeatError
from morph.print.mesh import Mesh, from_manifold
from morph.print.screw import screw
from morph.print.servos import SERVOS as SERVOS
from morph.print.servos import ServoSize as ServoSize
from morph.print.solid import box, hull, rod, union

Side = Literal["+z", "+y", "-y"]
"""Where a pocket is open: on the horn's side, or at one flank."""

DISC_MM = 4.0
"""Thickness of the disc that is screwed to a horn."""

RIM_MM = 1.5
"""How far that disc reaches beyond the horn."""

ARM_WALL_MM = 2.4
"""How much plastic there is around a horn that is an arm."""

FREE_MM = 0.6
"""Room about what turns."""

FAR_MM = 60.0
"""How far a screw is reached through what stands before it."""

REACH_MM = 0.2
"""Room around a screw's head on that way."""

SCREW_MM = 8.0
"""How deep a screw goes into plastic."""


def servo(name: str) -> ServoSize:
    """Return a servo by its name.

    Raises:
        SeatError: There is no such servo.
    """
    by_name = {known.name.lower(): known for known in SERVOS}
    if name.lower() in by_name:
        return by_name[name.lower()]
    near = difflib.get_close_matches(name.lower()[:100], by_name, n=1, cutoff=0.4)
    raise SeatError(
        f"no servo is called {name[:100]!r}; there are {', '.join(s.name for s in SERVOS)}",
        where="morph.print.servo",
        fix=f"name one of these, such as {by_name[near[0]].name if near else SERVOS[0].name}",
    )


def disc_radius(which: ServoSize) -> float:
    """Return the radius of the disc that is screwed to its horn, mm."""
    if which.horn.arm_mm is not None:
        return which.horn.arm_mm[0] + ARM_WALL_MM
    return which.horn.diameter_mm / 2 + RIM_MM


def case(which: ServoSize) -> Mesh:
    """Return its case with its flange, without its horn."""
    return from_manifold(_case(which, 0.0))


def body(which: ServoSize) -> Mesh:
    """Return all of it, with its horn."""
    return from_manifold(union([_case(which, 0.0), _horn(which)]))


def pocket(which: ServoSize, play_mm: float, side: Side = "+z") -> Mesh:
    """Return what must be empty for it to go in, to turn its horn, and for its wires.

    Args:
        which: The servo.
        play_mm: Room between it and its pocket, on each side.
        side: Where it goes in.
    """
    return from_manifold(
        union([way_in(which, play_mm, side), turning_room(which), wire_room(which, play_mm)])
    )


def way_in(which: ServoSize, play_mm: float, side: Side = "+z") -> Any:
    """Return the room of the case, and the way by which it comes there, as a solid."""
    room = _case(which, play_mm)
    far = which.height_mm + which.horn.top_mm if side == "+z" else which.width_mm
    away = {"+z": (0, 0, far), "+y": (0, far, 0), "-y": (0, -far, 0)}[side]
    # A flange keeps its step below, where it rests on the rim.
    parts = [part.hull() for part in ([room] if which.flange is None else _split(which, play_mm))]
    return union([hull([part, part.translate(list(away))]) for part in parts])


def turning_room(which: ServoSize) -> Any:
    """Return where its horn turns, with the disc that is screwed to it, as a solid."""
    top = which.horn.top_mm + DISC_MM + FREE_MM
    return rod(disc_radius(which) + FREE_MM, 0.0, top)


def screw_holes(which: ServoSize, floor_mm: float) -> Mesh | None:
    """Return what to cut for the screws that hold it; None if a strap holds it.

    Args:
        which: The servo.
        floor_mm: Thickness of the floor under its case, through which they may go.
    """
    if not which.holes_mm:
        return None
    size = screw(which.hole_screw)
    if which.held_by == "rim" and which.flange is not None:
        low, high, radius = -which.flange.depth_mm - SCREW_MM, 0.0, size.tap_mm / 2
    else:
        low, high = -which.height_mm - floor_mm - FREE_MM, -which.height_mm + 1.0
        radius = size.clear_mm / 2
    holes = [rod(radius, low, high, hole) for hole in which.holes_mm]
    if which.held_by == "floor":
        # A screw that cannot be reached holds nothing.
        under = -which.height_mm - floor_mm
        head = size.head_mm / 2 + REACH_MM
        holes += [rod(head, under - FAR_MM, under, hole) for hole in which.holes_mm]
    return from_manifold(union(holes))


def horn_pattern(which: ServoSize, play_mm: float) -> Mesh:
    """Return what to cut from the disc on its horn: its holes, and the room of an arm.

    Args:
        which: The servo.
        play_mm: Room about an arm, on each side; holes have their own.
    """
    horn = which.horn
    low, top = horn.top_mm - 0.1, horn.top_mm + DISC_MM + 0.1
    size = screw(horn.screw)
    parts = [rod(horn.centre_mm / 2, low, top)]
    parts += [rod(size.clear_mm / 2, low, top, at) for at in _circle(which)]
    if horn.arm_mm is not None:
        length, tip, thick = horn.arm_mm
        high = horn.top_mm + thick + play_mm
        hub = rod(horn.diameter_mm / 2 + play_mm, low, high)
        parts.append(hull([hub, rod(tip + play_mm, low, high, (length - tip, 0.0))]))
    return from_manifold(union(parts))


def horn_reach(which: ServoSize) -> Any:
    """Return the ways by which a driver reaches the screws of its horn, as a solid."""
    top = which.horn.top_mm + DISC_MM
    head = screw(which.horn.screw).head_mm / 2 + REACH_MM
    ways = [rod(head, top, top + FAR_MM, at) for at in _circle(which)]
    return union([rod(which.horn.centre_mm / 2, top - 0.1, top + FAR_MM), *ways])


def _circle(which: ServoSize) -> list[tuple[float, float]]:
    """Return where the screws of its horn are."""
    radius, turns = which.horn.circle_mm / 2, 2.0 * math.pi * np.arange(which.horn.count)
    turns = turns / max(which.horn.count, 1)
    return [(radius * math.cos(turn), radius * math.sin(turn)) for turn in turns]


def horn_disc(which: ServoSize) -> Any:
    """Return the disc that is screwed to its horn, without its holes, as a solid."""
    low, high = which.horn.top_mm, which.horn.top_mm + DISC_MM
    if which.horn.arm_mm is None:
        return rod(disc_radius(which), low, high)
    length, tip, _ = which.horn.arm_mm
    # A plate along the arm: its whole circle would be thrice as wide as the servo.
    hub = rod(which.horn.diameter_mm / 2 + ARM_WALL_MM, low, high)
    return hull([hub, rod(tip + ARM_WALL_MM, low, high, (length - tip, 0.0))])


def _case(which: ServoSize, play: float) -> Any:
    """Return the case and its flange, grown on all sides."""
    return union(_split(which, play))


def _split(which: ServoSize, play: float) -> list[Any]:
    """Return the case, and the part of its flange that is above its underside."""
    near, far = -which.axis_mm - play, which.length_mm - which.axis_mm + play
    half = which.width_mm / 2 + play
    parts = [box((near, -half, -which.height_mm - play), (far, half, play))]
    if which.flange is not None:
        middle = which.length_mm / 2 - which.axis_mm
        reach, low = which.flange.length_mm / 2 + play, -which.flange.depth_mm
        high = low + which.flange.thickness_mm + play
        parts.append(box((middle - reach, -half, low), (middle + reach, half, high)))
    return parts


def _horn(which: ServoSize) -> Any:
    horn = which.horn
    if horn.arm_mm is None:
        return rod(horn.diameter_mm / 2, 0.0, horn.top_mm)
    length, tip, thick = horn.arm_mm
    hub = rod(horn.diameter_mm / 2, 0.0, horn.top_mm + thick)
    low, high = horn.top_mm, horn.top_mm + thick
    arm = hull([rod(horn.diameter_mm / 2, low, high), rod(tip, low, high, (length - tip, 0.0))])
    return union([hub, arm])


def wire_room(which: ServoSize, play: float) -> Any:
    """Return a window through the floor, for its wires, as a solid."""
    low, high, half = which.wires_mm
    floor = -which.height_mm
    return box((low, -half, floor - play - 6.0), (high, half, floor + 0.5))
