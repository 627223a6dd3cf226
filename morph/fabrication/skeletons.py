"""Skeletons of the links that are drawn by simple solids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from morph.fabrication.drawing import Drawing
from morph.fabrication.off_the_shelf_parts import Item
from morph.fabrication.pieces import fusions, plastic, printed_links
from morph.fabrication.pivots import Axis, passive, pivots
from morph.fabrication.rigid import between, roots
from morph.print.mesh import Mesh
from morph.print.skeleton import Mount, Pivot, Skeleton


@dataclass(kw_only=True, eq=False)
class Bones:
    """What is gathered of one part, in the frame of its first link."""

    solids: list[Mesh] = field(default_factory=list)
    """What is drawn of it."""
    servos: list[Mount] = field(default_factory=list)
    """Servos in it."""
    horns: list[Mount] = field(default_factory=list)
    """Servos that turn it."""
    pivots: list[Pivot] = field(default_factory=list)
    """Joints without a servo."""
    boxes: list[Mesh] = field(default_factory=list)
    """Other bought things in it."""


def skeletons(drawing: Drawing, bought: Sequence[Item]) -> dict[str, Skeleton]:
    """Return a skeleton for each printed link that is not drawn by meshes, by its name.

    What is fused into a link is in that link's skeleton.
    """
    into = fusions(drawing, printed_links(drawing))
    bones = _drawn(drawing, bought, into)
    _hold(drawing, bought, into, bones)
    driven = {item.entry.joint for item in bought if item.seated is not None}
    solids = {
        link: [mesh.moved(drawing.world(link)) for mesh in result.solids]
        for link, result in bones.items()
        if result.solids or result.servos
    }
    joints = [axis for axis in passive(drawing, driven) if _grown(drawing, axis, bones)]
    for link, result in pivots(drawing, joints, solids).items():
        bones[link].pivots += result
    return {
        link: Skeleton(
            name=link,
            solids=tuple(result.solids),
            servos=tuple(result.servos),
            horns=tuple(result.horns),
            pivots=tuple(result.pivots),
            boxes=tuple(result.boxes),
        )
        for link, result in bones.items()
        if result.solids or result.servos or result.horns or result.pivots
    }


def _drawn(drawing: Drawing, bought: Sequence[Item], into: dict[str, str]) -> dict[str, Bones]:
    """Return what is drawn of each part; links that are drawn by meshes are not among them."""
    bones: dict[str, Bones] = {}
    for link in printed_links(drawing):
        shapes = plastic(drawing, link, bought)
        simple = [shape for shape in shapes if shape.kind != "mesh"]
        if len(simple) < len(shapes) and not simple:
            continue
        root = into.get(link, link)
        result = bones.setdefault(root, Bones())
        result.solids += [
            shape.mesh.moved(between(drawing, link, root) @ shape.pose) for shape in simple
        ]
    return bones


def _hold(
    drawing: Drawing, bought: Sequence[Item], into: dict[str, str], bones: dict[str, Bones]
) -> None:
    """Add what is bought to the parts that hold it, and servos' horns to what they turn."""
    for item in bought:
        link = item.entry.link
        root = into.get(link, link)
        here = between(drawing, link, root)
        if item.seated is None or item.servo is None:
            if item.drawn is not None and root in bones:
                bones[root].boxes.append(item.drawn.mesh.moved(here @ item.drawn.pose))
            continue
        if root in bones:
            bones[root].servos.append(Mount(servo=item.servo.name, pose=here @ item.seated.pose))
        other = _turned(drawing, item, into)
        if other in bones:
            there = between(drawing, link, other) @ item.seated.horn
            bones[other].horns.append(Mount(servo=item.servo.name, pose=there))


def _turned(drawing: Drawing, item: Item, into: dict[str, str]) -> str:
    """Return the part that a servo's horn turns."""
    robot, fixed = drawing.robot, roots(drawing.robot)
    joint = robot.joint(item.entry.joint)
    held_by_child = fixed[item.entry.link] == fixed[joint.link]
    other = robot.link(joint.link).parent if held_by_child else joint.link
    return into.get(other, other)


def _grown(drawing: Drawing, axis: Axis, bones: dict[str, Bones]) -> bool:
    """Return whether one side of a joint is grown from a skeleton."""
    fixed = roots(drawing.robot)
    sides = {fixed[axis.still], fixed[axis.moving]}
    return any(fixed[link] in sides for link in bones)
