"""Merge equal solids into one part with copies, and pair mirrored ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from morph.arrays import Array
from morph.fabrication.drawing import Drawing
from morph.fabrication.groups import PieceGroup
from morph.fabrication.names import UniqueNames, shared, sided
from morph.print.errors import PrintError
from morph.print.mesh import Mesh
from morph.print.part import Check, Part, Placement, Seat
from morph.print.printer import Profile
from morph.print.shell import Shell, shell
from morph.print.skeleton import Skeleton

TRIES = 4
"""How many rooms are left out one by one, before all are."""

Hand = Literal["left", "right"]


@dataclass(frozen=True, kw_only=True, eq=False)
class DeduplicatedParts:
    """What came of pieces that are alike."""

    parts: tuple[Part, ...]
    """None, one, or two that are twins."""
    checks: tuple[Check, ...] = ()
    """Why there is none, or what was found."""
    notes: tuple[str, ...] = ()
    """What a reader should know."""


def made(
    drawn: Drawing, group: PieceGroup, profile: Profile, names: UniqueNames
) -> DeduplicatedParts:
    """Return the parts of a group, its twin's too, or why there are none."""
    name = _name(group)
    try:
        grown, checks = _solid(group, profile, name)
    except PrintError as error:
        return DeduplicatedParts(parts=(), checks=(_check(names.one(name), "refused", error),))
    notes = tuple(f"{name}: {note}" for note in grown.notes)
    if group.twin is None or group.twin.mirror is None:
        parts = (_part(drawn, group, grown.mesh, grown.seats, names.one(name)),)
        return DeduplicatedParts(parts=parts, checks=checks, notes=notes)
    mirror = group.twin.mirror
    hands = _hands(drawn, group, group.twin)
    plain = "_".join(word for word in name.split("_") if word not in ("left", "right"))
    one = _part(drawn, group, grown.mesh, grown.seats, names.one(f"{plain}_{hands[0]}"))
    seats = tuple(_moved(seat, mirror) for seat in grown.seats)
    turned = grown.mesh.moved(mirror)
    other = _part(drawn, group.twin, turned, seats, names.one(f"{plain}_{hands[1]}"))
    pair = (replace(one, hand=hands[0]), replace(other, hand=hands[1]))
    return DeduplicatedParts(parts=pair, checks=checks, notes=notes)


def _check(name: str, verdict: Literal["noted", "refused"], error: PrintError) -> Check:
    return Check(part=name, name="shape", verdict=verdict, what=error.what, fix=error.fix)


def _name(group: PieceGroup) -> str:
    if group.first.file and all(piece.file == group.first.file for piece in group.pieces):
        return group.first.name
    return shared([piece.name for piece in group.pieces])


def _solid(group: PieceGroup, profile: Profile, name: str) -> tuple[Shell, tuple[Check, ...]]:
    """Return a piece's solid; if neighbours leave no room for one, one that is in their way."""
    piece = group.first
    if isinstance(piece.source, Mesh):
        return Shell(mesh=piece.source, seats=piece.seats, notes=()), ()
    rooms = (*piece.source.spared, *_others(group))
    body = replace(piece.source, spared=rooms)
    try:
        return shell(body, profile), ()
    except PrintError as error:
        if not rooms:
            raise
        # A part in the way is still a part: the clearance of its joints tells how far they turn.
        return _in_the_way(body, profile), (_check(name, "noted", error),)


def _others(group: PieceGroup) -> list[Mesh]:
    """Return the room that neighbours of its copies and of its twin need, as the first sees it."""
    twin = group.twin
    mirror = np.eye(4) if twin is None or twin.mirror is None else twin.mirror
    members = [*group.members[1:]]
    members += [(piece, move @ mirror) for piece, move in (twin.members if twin else ())]
    return [
        room.moved(np.asarray(np.linalg.inv(move), dtype=np.float64))
        for piece, move in members
        if isinstance(piece.source, Skeleton)
        for room in piece.source.spared
    ]


def _in_the_way(body: Skeleton, profile: Profile) -> Shell:
    """Return a part without the one room that it cannot leave, or without any."""
    # The last is what drawn plastic sweeps, which another part may print thinner.
    for left_out in range(len(body.spared) - 1, max(-1, len(body.spared) - 1 - TRIES), -1):
        rooms = tuple(room for at, room in enumerate(body.spared) if at != left_out)
        try:
            return shell(replace(body, spared=rooms), profile)
        except PrintError:
            continue
    return shell(replace(body, spared=()), profile)


def _part(
    drawn: Drawing, group: PieceGroup, mesh: Mesh, seats: tuple[Seat, ...], name: str
) -> Part:
    placements = tuple(
        Placement(
            link=piece.link,
            pose=piece.pose @ motion,
            world=drawn.world(piece.link) @ piece.pose @ motion,
        )
        for piece, motion in group.members
    )
    return Part(name=name, kind="printed", mesh=mesh, placements=placements, seats=seats)


def _hands(drawn: Drawing, one: PieceGroup, other: PieceGroup) -> tuple[Hand, Hand]:
    """Return the hands of two twins: y points to the left."""
    statement = sided(piece.name for piece, _ in one.members)
    statement = statement or sided(piece.link for piece, _ in one.members)
    if statement == "left":
        return ("left", "right")
    if statement == "right":
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
