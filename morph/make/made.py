"""Parts of what is alike: one with several copies, or two that are mirrored twins."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from morph.arrays import Array
from morph.make.drawing import Drawing
from morph.make.groups import Group
from morph.make.names import Names, shared, sided
from morph.make.pieces import Piece
from print.errors import PrintError
from print.mesh import Mesh
from print.part import Check, Part, Placement, Seat
from print.printer import Profile
from print.shell import shell

Hand = Literal["left", "right"]


def made(
    drawn: Drawing, group: Group, profile: Profile, names: Names
) -> tuple[list[Part], list[Check]]:
    """Return the parts of a group, its twin's too, or why there are none."""
    name = _name(group)
    try:
        mesh, seats = _solid(group.first, profile)
    except PrintError as error:
        return [], [
            Check(
                part=names.one(name),
                name="shape",
                verdict="refused",
                what=error.what,
                fix=error.fix,
            )
        ]
    if group.twin is None or group.twin.mirror is None:
        return [_part(drawn, group, mesh, seats, names.one(name))], []
    mirror = group.twin.mirror
    hands = _hands(drawn, group, group.twin)
    other = _part(
        drawn,
        group.twin,
        mesh.moved(mirror),
        tuple(_moved(seat, mirror) for seat in seats),
        names.one(f"{name}_{hands[1]}"),
    )
    one = _part(drawn, group, mesh, seats, names.one(f"{name}_{hands[0]}"))
    return [replace(one, hand=hands[0]), replace(other, hand=hands[1])], []


def _name(group: Group) -> str:
    every = [*group.members, *(group.twin.members if group.twin else [])]
    if group.first.file and all(piece.file == group.first.file for piece, _ in every):
        return group.first.name
    return shared([piece.name for piece, _ in every])


def _solid(piece: Piece, profile: Profile) -> tuple[Mesh, tuple[Seat, ...]]:
    if isinstance(piece.source, Mesh):
        return piece.source, ()
    grown = shell(piece.source, profile)
    return grown.mesh, grown.seats


def _part(drawn: Drawing, group: Group, mesh: Mesh, seats: tuple[Seat, ...], name: str) -> Part:
    placements = tuple(
        Placement(
            link=piece.link,
            pose=piece.pose @ motion,
            world=drawn.world(piece.link) @ piece.pose @ motion,
        )
        for piece, motion in group.members
    )
    return Part(name=name, kind="printed", mesh=mesh, placements=placements, seats=seats)


def _hands(drawn: Drawing, one: Group, other: Group) -> tuple[Hand, Hand]:
    """Return the hands of two twins: y points to the left."""
    said = sided(piece.link for piece, _ in one.members)
    if said == "left":
        return ("left", "right")
    if said == "right":
        return ("right", "left")
    across = [
        np.mean([(drawn.world(piece.link) @ piece.pose)[1, 3] for piece, _ in group.members])
        for group in (one, other)
    ]
    return ("left", "right") if across[0] >= across[1] else ("right", "left")


def _moved(seat: Seat, pose: Array) -> Seat:
    return replace(
        seat,
        position=pose[:3, :3] @ seat.position + pose[:3, 3],
        axis=pose[:3, :3] @ seat.axis,
        pocket=None if seat.pocket is None else seat.pocket.moved(pose),
    )
