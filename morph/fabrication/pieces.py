"""What is to be printed of each link: its meshes as they are, or a skeleton to grow a part from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.fabrication.drawing import Drawing, LinkShape
from morph.fabrication.names import of_file
from morph.fabrication.off_the_shelf_parts import Item
from morph.fabrication.point_set_registration import cloud
from morph.fabrication.seats import seats
from morph.print.mesh import Mesh
from morph.print.part import Seat
from morph.print.skeleton import Mount, Skeleton


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """One thing to print, before those that are alike are found."""

    name: str
    """What to call it if it stays alone."""
    link: str
    """The link that it belongs to."""
    source: Mesh | Skeleton
    """Its surface, or what it is to be grown from, in its own frame."""
    pose: Array
    """From its own frame into the link's, shape (4, 4), mm."""
    file: str = ""
    """The file that holds its mesh."""
    seats: tuple[Seat, ...] = ()
    """What is held in a mesh, in its own frame; a shell finds its own."""

    def points(self) -> Array:
        """Return points that tell it from others, shape (n, 4)."""
        if isinstance(self.source, Mesh):
            return cloud((0.0, self.source.vertices))
        body = self.source
        return cloud(
            *((1.0, mesh.vertices) for mesh in body.solids),
            *((2.0, mesh.vertices) for mesh in body.boxes),
            *((4.0, _frame(mount)) for mount in body.servos),
            *((5.0, _frame(mount)) for mount in body.horns),
            *(
                (6.0 + pivot.side, np.stack([pivot.position, pivot.position + 10 * pivot.axis]))
                for pivot in body.pivots
            ),
        )


def _frame(mount: Mount) -> Array:
    """Return three points of a mount; a servo is like its mirror image across its x and z."""
    origin, x, z = mount.pose[:3, 3], mount.pose[:3, 0], mount.pose[:3, 2]
    return np.stack([origin, origin + 10.0 * x, origin + 7.0 * z])


def printed_links(drawing: Drawing) -> tuple[str, ...]:
    """Return the links that are printed: those that the card names, or all that are drawn."""
    card = drawing.robot.card
    if card is not None and card.print is not None:
        named = set(card.print.printed) | set(card.print.fused)
        return tuple(link.name for link in drawing.robot.links if link.name in named)
    return tuple(link.name for link in drawing.robot.links if drawing.shapes[link.name])


def fusions(drawing: Drawing, printed: Sequence[str]) -> dict[str, str]:
    """Return for each link that is one piece with another that other one.

    That is what the card says, and what hangs without a joint from what is printed, unless it
    is drawn by meshes: these are parts of their own, which are screwed together.
    """
    robot, card = drawing.robot, drawing.robot.card
    names = set(card.print.fused) if card is not None and card.print is not None else set()
    moved = {joint.link for joint in robot.joints}
    into: dict[str, str] = {}
    for link in robot.links:
        still = link.name in names or link.name not in moved
        meshes = any(shape.kind == "mesh" for shape in drawing.shapes[link.name])
        if still and link.name in printed and link.parent in printed and not meshes:
            into[link.name] = into.get(link.parent, link.parent)
    return into


def plastic(drawing: Drawing, link: str, bought: Sequence[Item]) -> tuple[LinkShape, ...]:
    """Return what is drawn of a link and not bought."""
    taken = {id(item.drawn) for item in bought}
    return tuple(shape for shape in drawing.shapes[link] if id(shape) not in taken)


def pieces(
    drawing: Drawing, bought: Sequence[Item], skeletons: Mapping[str, Skeleton]
) -> tuple[Piece, ...]:
    """Return everything to print, in the order of the tree."""
    results = []
    for link in printed_links(drawing):
        shapes = plastic(drawing, link, bought)
        meshes = [shape for shape in shapes if shape.kind == "mesh"]
        results += [
            Piece(
                name=_name(shape),
                link=link,
                source=shape.mesh,
                pose=shape.pose,
                file=shape.file,
                seats=seats(shape, meshes, bought),
            )
            for shape in meshes
        ]
        if link in skeletons:
            results.append(Piece(name=link, link=link, source=skeletons[link], pose=np.eye(4)))
    return tuple(results)


def _name(shape: LinkShape) -> str:
    return of_file(shape.file) if shape.file else shape.name or shape.link
