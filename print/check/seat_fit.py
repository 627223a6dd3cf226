"""Whether what a part is to hold can go in, and is held."""

from __future__ import annotations

import numpy as np

from morph.print.arrays import Array
from morph.print.check.subject import Subject
from morph.print.errors import SolidError
from morph.print.mesh import Mesh
from morph.print.part import Check, Seat
from morph.print.samples import samples
from morph.print.solid import frame

NAME = "seat fit"
CLOSED_MM, NARROW_MM = 1.2, 2.0
"""Holes below the first diameter print shut; below the second they are to be drilled. A line and a
half on each side of a layer's outline is the least that leaves a hole open (rule of thumb)."""
FILLED_MM3 = 1.0
"""Most plastic that may stand in a pocket: rounding and facets, no more."""
ROUNDING_MM = 0.1
"""How much narrower than stated a bore may be anywhere: the chord of a coarse circle."""
SKIN_MM = 0.05
"""How far inside a pocket's surface is looked from: pockets are cut out of the part exactly there,
and one that is promised a little smaller must not have its walls behind it."""
NEAR_MM = 5.0
"""Within this distance around a pocket or a bore there is something that holds."""
HELD = 0.05
"""Least part of the surroundings that holds."""
DEPTHS_MM = (0.5, 1.0, 2.0)
"""Depths at which a bore is felt for, from its mouth inward."""
AROUND = 16
"""Directions in which it is felt for."""


def seat_fit(subject: Subject) -> Check:
    """Return whether every seat of a part is empty where it must be and held where it should be."""
    faults = [fault for seat in subject.part.seats if (fault := _fault(subject, seat))]
    if faults:
        more = f"; and {len(faults) - 3} more" if len(faults) > 3 else ""
        fix = "move the seat, or give the part more material around it"
        return subject.says(NAME, "refused", "; ".join(faults[:3]) + more, fix, value=len(faults))
    bores = [seat.bore_mm for seat in subject.part.seats if seat.bore_mm > 0]
    if bores and min(bores) < NARROW_MM:
        what = f"a hole of {min(bores):.2g} mm prints narrower than drawn"
        fix = "drill it after printing"
        return subject.says(NAME, "noted", what, fix, value=min(bores), limit=NARROW_MM)
    count = len(subject.part.seats)
    what = f"{count} seat{'s' if count != 1 else ''}, empty and held" if count else "holds nothing"
    return subject.says(NAME, "passed", what, value=0, limit=0)


def _fault(subject: Subject, seat: Seat) -> str:
    """Return what is wrong with a seat; empty if nothing is."""
    at = f"the seat of {seat.holds} at ({', '.join(f'{x:.3g}' for x in seat.position)}) mm"
    if 0 < seat.bore_mm < CLOSED_MM:
        return f"{at} has a hole of {seat.bore_mm:.2g} mm, and {CLOSED_MM} mm is the least"
    fault = ""
    if seat.pocket is not None:
        fault = _pocket(subject.mesh, seat.pocket)
    if not fault and seat.bore_mm > 0:
        fault = _bore(subject.mesh, seat)
    return f"{at} {fault}" if fault else ""


def _pocket(mesh: Mesh, pocket: Mesh) -> str:
    try:
        filled = float((mesh.manifold ^ pocket.manifold).volume())
    except SolidError as error:
        return f"cannot be looked at: {error.what}"
    if filled > FILLED_MM3:
        return f"is filled by {filled:.3g} mm3 of plastic, {FILLED_MM3:g} mm3 is allowed"
    result = samples(pocket, 200)
    # From a little inside: a pocket that was cut out of the part has its walls where they are.
    beside = _met(mesh, result.points - SKIN_MM * result.normals, result.normals, NEAR_MM)
    if float(np.isfinite(beside).mean()) < HELD:
        return f"has nothing around it that holds, within {NEAR_MM:g} mm"
    return ""


def _bore(mesh: Mesh, seat: Seat) -> str:
    """Return what is wrong with a round hole about the seat's axis."""
    radius = seat.bore_mm / 2.0
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    pose = frame(seat.position, seat.axis)
    ring = np.outer(np.cos(angle), pose[:3, 0]) + np.outer(np.sin(angle), pose[:3, 1])
    held = False
    for depth in DEPTHS_MM:
        middle = np.tile(seat.position - depth * pose[:3, 2], (AROUND, 1))
        apart = _met(mesh, middle, ring, radius + NEAR_MM)
        inside = mesh.manifold.ray_cast(middle[0], middle[0] + 1e4 * ring[0])
        if len(inside) % 2 or apart.min() < radius - ROUNDING_MM:
            least = 0.0 if len(inside) % 2 else 2.0 * float(apart.min())
            return f"is {least:.2g} mm wide at {depth:g} mm, and {seat.bore_mm:.3g} mm is needed"
        held = held or float(np.isfinite(apart).mean()) >= 0.5
    if not held:
        return f"has nothing around its hole of {seat.bore_mm:.3g} mm"
    out = _met(mesh, seat.position[None, :], pose[None, :3, 2], seat.bore_mm)
    return "opens into plastic: its hole is closed" if np.isfinite(out).any() else ""


def _met(mesh: Mesh, starts: Array, directions: Array, reach: float) -> Array:
    """Return how far rays go before they meet a mesh, mm; infinite if they do not within reach."""
    solid, result = mesh.manifold, np.full(len(starts), np.inf)
    for at, (start, direction) in enumerate(zip(starts, directions, strict=True)):
        hits = solid.ray_cast(start, start + reach * direction)
        if hits:
            result[at] = hits[0].distance * reach
    return result
