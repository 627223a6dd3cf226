"""From a skeleton to a part that can be printed: one solid that holds what it must hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.print.connect import connected
from morph.print.errors import SeatError
from morph.print.fit_box import tray
from morph.print.fit_pivot import pivot
from morph.print.fit_servo import horn, pockets
from morph.print.fitting import Fitting, all_added, all_removed, carried
from morph.print.mesh import Mesh, from_manifold
from morph.print.part import Seat
from morph.print.printer import Profile
from morph.print.skeleton import Skeleton
from morph.print.solid import union
from morph.print.thicken import thickened

THIN_MM = 1.6
"""Least width of a drawn solid; thinner ones are thickened, or to twice a line if that is more."""

HAIR_MM = 0.005
"""How far each drawn solid is grown; rounding would leave membranes between those that touch."""

CARRIED = 0.3
"""Least part of what carries something that must be left of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Shell:
    """A part grown from a skeleton."""

    mesh: Mesh
    """Its solid, in the skeleton's frame."""
    seats: tuple[Seat, ...]
    """What is held in it."""
    notes: tuple[str, ...]
    """What a reader should know: what was thickened, joined and dropped."""


def shell(skeleton: Skeleton, profile: Profile) -> Shell:
    """Return one printable solid grown from a skeleton.

    Its body is joined, with a pocket for each servo, a disc for each horn, a boss for each pivot
    and a tray for each box; rooms are cut; what lies apart is joined by struts.

    Args:
        skeleton: The part before it has a shape.
        profile: How it is printed.

    Raises:
        SolidError: Nothing is left, or pieces cannot be joined outside of what is spared.
        SeatError: A servo, a bearing or a screw is unknown, or too little is left to hold one.
    """
    body, notes = _body(skeleton, profile)
    fittings = _fittings(skeleton, body, profile)
    spared, given_up = _spared(skeleton, fittings)
    forbidden = union([*all_removed(fittings), spared])
    grown = union([body, *all_added(fittings)])
    solid, joined = connected(
        grown - forbidden, forbidden, all_added(fittings), where=skeleton.name
    )
    _refuse_lost(fittings, solid, skeleton.name)
    return Shell(
        mesh=from_manifold(solid),
        seats=tuple(seat for fitting in fittings for seat in fitting.seats),
        notes=(
            *notes,
            *_unique(note for fitting in fittings for note in fitting.notes),
            *given_up,
            *joined,
        ),
    )


def _body(skeleton: Skeleton, profile: Profile) -> tuple[Any, tuple[str, ...]]:
    """Return the drawn solids as one, thin ones thickened, and how many those are."""
    least = max(THIN_MM, profile.thinnest_mm)
    thick = [thickened(mesh, least) for mesh in skeleton.solids]
    count = sum(new is not old for new, old in zip(thick, skeleton.solids, strict=True))
    notes = (f"{count} thin shapes are made {least:.1f} mm thick",) if count else ()
    return union([_touching(mesh.manifold) for mesh in thick]), notes


def _touching(solid: Any) -> Any:
    """Return a solid a hair larger about its middle, so that faces that only touch become one."""
    low, high = np.array(solid.bounding_box()).reshape(2, 3)
    middle = (low + high) / 2.0
    factor = 1.0 + 2.0 * HAIR_MM / (high - low)
    return solid.translate(list(-middle)).scale(list(factor)).translate(list(middle))


def _fittings(skeleton: Skeleton, body: Any, profile: Profile) -> tuple[Fitting, ...]:
    discs = tuple(horn(mount, profile) for mount in skeleton.horns)
    far = _size(skeleton)
    bosses = tuple(
        pivot(each, [other for other in skeleton.pivots if other is not each], far, profile)
        for each in skeleton.pivots
    )
    so_far = union([body, *all_added((*discs, *bosses))])
    held = pockets(skeleton.servos, so_far, profile)
    trays = tuple(tray(box, so_far, profile) for box in skeleton.boxes)
    return (*discs, *bosses, *held, *trays)


def _size(skeleton: Skeleton) -> float:
    """Return a length greater than the part, mm."""
    corners = [mesh.bounds for mesh in (*skeleton.solids, *skeleton.boxes)]
    corners += [mount.pose[None, :3, 3] for mount in (*skeleton.servos, *skeleton.horns)]
    corners += [each.position[None] for each in skeleton.pivots]
    return 100.0 + float(np.linalg.norm(np.ptp(np.vstack(corners), axis=0)))


def _spared(skeleton: Skeleton, fittings: Sequence[Fitting]) -> tuple[Any, tuple[str, ...]]:
    """Return the room that others sweep, less what carries something and would not be left."""
    room = union([mesh.manifold for mesh in skeleton.spared])
    if room.is_empty():
        return room, ()
    notes = []
    for fitting in fittings:
        plastic = union(fitting.added)
        if carried(fitting, plastic - room) < CARRIED:
            room -= plastic
            notes.append(
                f"others sweep through {fitting.name}, which stays: a joint will not have all "
                "of its range"
            )
    return room, tuple(notes)


def _refuse_lost(fittings: Sequence[Fitting], solid: Any, name: str) -> None:
    """Refuse a part of which too little is left to carry something."""
    for fitting in fittings:
        left = carried(fitting, solid)
        if left < CARRIED:
            raise SeatError(
                f"what else the part holds leaves {left:.0%} of what carries {fitting.name}",
                where=name,
                fix="move what it holds further apart",
            )


def _unique(notes: Any) -> list[str]:
    return list(dict.fromkeys(notes))
