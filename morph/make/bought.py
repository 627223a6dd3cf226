"""What a body's card says is bought, where it sits and what it weighs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.card import Bought
from morph.make.drawing import MM, Drawing, Drawn
from morph.make.mounts import Seated, seated
from print.mesh import Mesh
from print.part import Part, Placement
from print.weight import Weight, box

SAME = 0.1
"""How much two things of one name may differ in size and be the same, mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Item:
    """One thing that is bought, in its place."""

    entry: Bought
    """What the card says."""
    drawn: Drawn | None
    """The shape that stands for it."""
    seated: Seated | None
    """How it sits, if it is a servo whose joint is known."""


def items(drawing: Drawing) -> tuple[tuple[Item, ...], tuple[str, ...]]:
    """Return everything that the card says is bought, and what had to be assumed."""
    card = drawing.robot.card
    found, notes = [], []
    for entry in card.print.bought if card is not None and card.print is not None else ():
        shapes = {shape.name: shape for shape in drawing.shapes.get(entry.link, ())}
        drawn = shapes.get(entry.shape) if entry.shape else None
        known = any(joint.name == entry.joint for joint in drawing.robot.joints)
        if entry.shape and drawn is None:
            notes.append(f"{entry.link} has no shape {entry.shape!r} that stands for {entry.part}")
        if drawn is None:
            notes.append(
                f"where {entry.part} sits in {entry.link} is not known: "
                "its mass is taken to sit at the link's centre of mass, without extent"
            )
        elif entry.count > 1:
            notes.append(f"all {entry.count} of {entry.part} are taken to sit at {entry.shape}")
        if entry.joint and not known:
            notes.append(f"{entry.part} is to turn {entry.joint!r}, which is no joint")
        seat = seated(drawing, drawn, entry.joint) if drawn is not None and known else None
        found += [Item(entry=entry, drawn=drawn, seated=seat)] * entry.count
    return tuple(found), tuple(notes)


def parts(drawing: Drawing, found: Sequence[Item]) -> tuple[tuple[Part, tuple[Item, ...]], ...]:
    """Return what is bought as parts, equal ones as one, each with its items; not yet named."""
    groups: list[list[tuple[Item, Array]]] = []
    for item in found:
        size = _size(item)
        for group in groups:
            first, like = group[0]
            same = first.entry.part == item.entry.part and first.entry.mass_kg == item.entry.mass_kg
            if same and np.abs(like - size).max() <= SAME:
                group.append((item, size))
                break
        else:
            groups.append([(item, size)])
    return tuple(
        (_part(drawing, [item for item, _ in group]), tuple(item for item, _ in group))
        for group in groups
    )


def pose(drawing: Drawing, item: Item) -> Array:
    """Return where a bought thing's middle is in its link, and how it is turned, mm."""
    if item.seated is not None:
        return item.seated.case
    if item.drawn is not None:
        return item.drawn.pose
    where = np.eye(4)
    where[:3, 3] = MM * np.array(drawing.robot.link(item.entry.link).com)
    return where


def _size(item: Item) -> Array:
    if item.seated is not None:
        return item.seated.size
    return np.zeros(3) if item.drawn is None else 2.0 * item.drawn.size


def _part(drawing: Drawing, group: Sequence[Item]) -> Part:
    placements = tuple(
        Placement(
            link=item.entry.link,
            pose=pose(drawing, item),
            world=drawing.world(item.entry.link) @ pose(drawing, item),
        )
        for item in group
    )
    mesh = _mesh(group[0])
    return Part(
        name=group[0].entry.part,
        kind="bought",
        mesh=mesh,
        placements=placements,
        weight=_weight(group[0].entry.mass_kg, group[0], mesh),
    )


def _mesh(item: Item) -> Mesh | None:
    if item.drawn is None:
        return None
    if item.seated is None:
        return item.drawn.mesh
    turn = np.linalg.inv(item.seated.case) @ item.drawn.pose
    return item.drawn.mesh.moved(turn)


def _weight(mass: float, item: Item, mesh: Mesh | None) -> Weight:
    """Return what one weighs: a uniform box of its size, about its middle."""
    if mesh is None:
        return Weight(mass=mass, com=np.zeros(3), inertia=np.zeros((3, 3)))
    middle = mesh.bounds.mean(axis=0)
    about = box(mass, mesh.extent)
    return Weight(mass=mass, com=middle / MM, inertia=about.inertia)
