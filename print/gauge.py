"""Fit gauges: small blocks to print first, that tell which play lets things go in."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.print.bearing import bearing
from morph.print.bed import room
from morph.print.errors import SeatError
from morph.print.mesh import from_manifold
from morph.print.part import Part, Placement, Seat
from morph.print.printer import Profile
from morph.print.servo import servo
from morph.print.solid import around, frame

PLAYS_MM = (0.1, 0.2, 0.3, 0.4)
"""Play on each side of the openings of a gauge; as many notches as its place in the list."""
THICK_MM = 5.0
"""Height of a gauge."""
WALL_MM = 2.4
"""Plastic between two openings."""
MOUTH_MM = 1.0
"""How far below its mouth a pocket's outline is taken."""
NOTCH_MM = 1.4
"""Width and depth of a notch."""


def gauges(parts: Sequence[Part], profile: Profile) -> tuple[Part, ...]:
    """Return a gauge for each kind of seat in the parts, in the order in which they are met.

    A gauge has the opening of the seat four times, with the play of `PLAYS_MM`, and beside each
    one to four notches, so that it can be read without a legend. What fits best is the
    `clearance_mm` to print the parts with.

    Args:
        parts: The parts; only what is printed holds anything.
        profile: The play that the parts have now, and the bed.
    """
    seats: dict[str, Seat] = {}
    for part in parts:
        if part.kind == "printed":
            for seat in part.seats:
                if seat.pocket is not None or seat.bore_mm > 0:
                    seats.setdefault(_name(seat), seat)
    here = Placement(link="", pose=np.eye(4), world=np.eye(4))
    return tuple(
        Part(
            name=name,
            kind="printed",
            mesh=from_manifold(_block(_openings(seat, profile), profile)),
            placements=(here,),
        )
        for name, seat in seats.items()
    )


def _name(seat: Seat) -> str:
    """Return the gauge's name: seats of one name and one bore have one gauge."""
    held = re.sub(r"[^a-z0-9]+", "_", seat.holds.lower()).strip("_")
    bore = f"_{seat.bore_mm:.1f}".replace(".", "_") if seat.pocket is None else ""
    return f"gauge_{held}{bore}"


def _openings(seat: Seat, profile: Profile) -> list[Any]:
    """Return a seat's opening seen along its axis, about the origin, for each play.

    Of what is in a catalogue the outline is known; otherwise it is that of the pocket or the
    bore, which have the profile's play already.
    """
    plays = np.array(PLAYS_MM)
    if seat.pocket is None:
        return [_round(seat.bore_mm / 2.0 + by) for by in plays - profile.clearance_mm]
    try:
        known = servo(seat.holds)
        # The shorter side along the row.
        return [_oblong(known.width_mm + 2 * by, known.length_mm + 2 * by) for by in plays]
    except SeatError:
        pass
    try:
        # A bearing is pressed in, so a shell gives it half the play.
        return [_round((bearing(seat.holds).outer_mm + by) / 2.0) for by in plays]
    except SeatError:
        pass
    into = np.asarray(np.linalg.inv(frame(seat.position, seat.axis)), dtype=np.float64)
    room = seat.pocket.moved(into).manifold
    # Just below its mouth, where something sits; the way to it may be wider.
    seen = room.slice(-MOUTH_MM)
    seen = room.project() if seen.is_empty() else seen
    return [_centred(_grown(seen, float(by))) for by in plays - profile.clearance_mm]


def _block(openings: list[Any], profile: Profile) -> Any:
    """Return a plate with the openings in a row, or in a column where a row is too long."""
    import manifold3d

    boxes = np.array([opening.bounds() for opening in openings])
    width, depth = (boxes[:, 2:] - boxes[:, :2]).max(axis=0)
    notches = 2.0 * NOTCH_MM * len(openings)
    pitch = np.array([max(width, notches) + WALL_MM, depth + 2.0 * WALL_MM + NOTCH_MM])
    across = len(openings)
    while across > 1 and across * pitch[0] + WALL_MM > room(profile)[0]:
        across //= 2
    rows = -(-len(openings) // across)
    size = np.array([across * pitch[0] + WALL_MM, rows * pitch[1]])
    plate = manifold3d.CrossSection.square(size.tolist())
    for at, opening in enumerate(openings):
        row, column = divmod(at, across)
        middle = (column + 0.5) * pitch[0] + WALL_MM / 2.0
        low = row * pitch[1]
        plate -= opening.translate((middle, low + NOTCH_MM + WALL_MM + depth / 2.0))
        for notch in range(at + 1):
            left = middle + (2.0 * notch - at - 0.5) * NOTCH_MM
            # Along the lower edge of each row; inside the plate they are square holes.
            cut = manifold3d.CrossSection.square((NOTCH_MM, NOTCH_MM))
            plate -= cut.translate((left, low + (WALL_MM / 2.0 if row else 0.0)))
    return plate.extrude(THICK_MM)


def _round(radius: float) -> Any:
    import manifold3d

    return manifold3d.CrossSection.circle(max(radius, 0.1), around(radius))


def _oblong(width: float, depth: float) -> Any:
    import manifold3d

    return manifold3d.CrossSection.square((width, depth), center=True)


def _grown(section: Any, by: float) -> Any:
    import manifold3d

    return section.offset(by, manifold3d.JoinType.Miter) if by else section


def _centred(section: Any) -> Any:
    low_x, low_y, high_x, high_y = section.bounds()
    return section.translate((-(low_x + high_x) / 2.0, -(low_y + high_y) / 2.0))
