"""Bought parts of a body's card: where they sit and what they weigh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.card import Bought
from morph.fabrication.drawing import MM, Drawing, LinkShape
from morph.fabrication.mounts import Seated, seated
from morph.fabrication.printed import designed
from morph.print.errors import SeatError
from morph.print.mesh import Mesh
from morph.print.part import Check, Part, Placement
from morph.print.servo import case, servo
from morph.print.servos import ServoSize
from morph.print.weight import Weight, box

SAME = 0.1
"""How much two things of one name may differ in size and be the same, mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Item:
    """One thing that is bought, in its place."""

    entry: Bought
    """What the card says."""
    drawn: LinkShape | None
    """The shape that stands for it."""
    servo: ServoSize | None = None
    """What the catalogue says of it, if it is a servo that turns a joint."""
    seated: Seated | None = None
    """How it sits, if it is one."""
    whole: bool = False
    """Whether it is all of its link, which then weighs what the description says."""


def items(drawing: Drawing) -> tuple[tuple[Item, ...], tuple[str, ...]]:
    """Return everything that the card says is bought, and what had to be assumed."""
    card = drawing.robot.card
    results: list[Item] = []
    notes: list[str] = []
    if card is None or card.print is None:
        return (), ()
    for entry in card.print.bought:
        others = sum(each.link == entry.link for each in card.print.bought)
        whole = not entry.shape and entry.link not in card.print.printed and others == 1
        item = _item(drawing, entry, whole and entry.count == 1)
        notes += _assumed(drawing, entry, item)
        results += [item] * entry.count
    return tuple(results), tuple(notes)


def _item(drawing: Drawing, entry: Bought, whole: bool) -> Item:
    shapes = {shape.name: shape for shape in drawing.shapes.get(entry.link, ())}
    drawn = shapes.get(entry.shape) if entry.shape else None
    known = any(joint.name == entry.joint for joint in drawing.robot.joints)
    which = _servo(entry.part) if drawn is not None and known else None
    if drawn is None or which is None:
        return Item(entry=entry, drawn=drawn, whole=whole)
    return Item(
        entry=entry,
        drawn=drawn,
        servo=which,
        seated=seated(drawing, drawn, entry.joint, which),
    )


def _servo(name: str) -> ServoSize | None:
    try:
        return servo(name)
    except SeatError:
        return None


def _assumed(drawing: Drawing, entry: Bought, item: Item) -> list[str]:
    """Return what had to be assumed of a thing."""
    notes = []
    if entry.shape and item.drawn is None:
        notes.append(f"{entry.link} has no shape {entry.shape!r} that could be {entry.part}")
    if item.drawn is None and not item.whole:
        notes.append(
            f"where {entry.part} sits in {entry.link} is not known: "
            "its mass is taken to sit at the link's centre of mass, without extent"
        )
    if item.drawn is not None and entry.count > 1:
        notes.append(f"all {entry.count} of {entry.part} are taken to sit at {entry.shape}")
    if entry.joint and not any(joint.name == entry.joint for joint in drawing.robot.joints):
        notes.append(f"{entry.part} is to turn {entry.joint!r}, which is no joint")
    elif entry.joint and item.seated is None:
        notes.append(f"no sizes of {entry.part} are known: {entry.joint} gets room, but no horn")
    return notes


def axes(results: Sequence[Item]) -> tuple[Check, ...]:
    """Return a check of each servo: whether its axis is on that of the joint that it turns."""
    checks = []
    for item in results:
        if item.seated is None or item.seated.fits:
            continue
        seat = item.seated
        lean = f" and leans {seat.off_deg:.0f} degrees from it" if seat.off_deg > 2.0 else ""
        checks.append(
            Check(
                part=item.entry.joint,
                name="servo axis",
                verdict="noted",
                what=f"the axis of the {item.entry.part} drawn as {item.entry.shape} is "
                f"{seat.off_mm:.1f} mm from the joint's{lean}; it sits where it is drawn, and "
                "what it turns has its disc on the joint's axis",
                fix=f"move {item.entry.shape} in the description, so that its axis is the joint's",
                value=seat.off_mm,
                limit=2.0,
            )
        )
    return tuple(checks)


def parts(drawing: Drawing, results: Sequence[Item]) -> tuple[Part, ...]:
    """Return what is bought as parts, equal ones as one; not yet named."""
    groups: list[tuple[Part, Item, list[Placement]]] = []
    for item in results:
        made = _part(drawing, item)
        for like, first, placements in groups:
            if _same(first, item, like, made):
                placements += made.placements
                break
        else:
            groups.append((made, item, list(made.placements)))
    return tuple(replace(part, placements=tuple(places)) for part, _, places in groups)


def _same(first: Item, item: Item, like: Part, made: Part) -> bool:
    if (first.entry.part, first.entry.mass_kg) != (item.entry.part, item.entry.mass_kg):
        return False
    if like.mesh is None or made.mesh is None:
        return like.mesh is made.mesh and not item.whole
    return bool(np.abs(like.mesh.extent - made.mesh.extent).max() <= SAME)


def _part(drawing: Drawing, item: Item) -> Part:
    mesh, weight, pose = _solid(drawing, item)
    place = Placement(link=item.entry.link, pose=pose, world=drawing.world(item.entry.link) @ pose)
    return Part(name=item.entry.part, kind="bought", mesh=mesh, placements=(place,), weight=weight)


def _solid(drawing: Drawing, item: Item) -> tuple[Mesh | None, Weight, Array]:
    """Return the solid of a thing, what it weighs, and its pose in its link."""
    mass, link = item.entry.mass_kg, item.entry.link
    if item.servo is not None and item.seated is not None:
        which = item.servo
        size = np.array([which.length_mm, which.width_mm, which.height_mm])
        middle = np.array([size[0] / 2 - which.axis_mm, 0.0, -size[2] / 2])
        weight = Weight(mass=mass, com=middle / MM, inertia=box(mass, size).inertia)
        return case(which), weight, item.seated.pose
    if item.drawn is not None:
        mesh = item.drawn.mesh
        middle = mesh.bounds.mean(axis=0)
        weight = Weight(mass=mass, com=middle / MM, inertia=box(mass, mesh.extent).inertia)
        return mesh, weight, item.drawn.pose
    as_designed = designed(drawing.robot)[link]
    if item.whole and as_designed.mass > 0:
        return None, as_designed.scaled(mass), np.eye(4)
    where = np.eye(4)
    where[:3, 3] = MM * as_designed.com
    return None, Weight(mass=mass, com=np.zeros(3), inertia=np.zeros((3, 3))), where
