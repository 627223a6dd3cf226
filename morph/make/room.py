"""Room that neighbours sweep: what each part must keep out of, and which of two gives way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.make.drawing import Drawing
from morph.make.rigid import roots
from morph.make.sweep import rough, swept
from print.fit_pivot import FREE_MM, axle
from print.mesh import Mesh, from_manifold
from print.part import Hinge
from print.servo import servo
from print.skeleton import Mount, Skeleton
from print.solid import box, frame, placed, rod, union

GAP_MM = 0.6
"""Room between what moves and what stays."""

WALL_MM = 3.0
"""Walls of a servo's pocket with their play: others keep out of these too."""


def spared(
    drawing: Drawing, skeletons: Mapping[str, Skeleton], hinges: Sequence[Hinge]
) -> dict[str, Skeleton]:
    """Return skeletons with the room that their neighbours need.

    Drawn plastic yields to servos, to their pockets and to the discs on their horns. Of the
    plastic of two neighbours, that yields which loses less. Only neighbours are looked at.
    """
    fixed = roots(drawing.robot)
    bodies = {name: _Body(drawing, each) for name, each in skeletons.items()}
    rooms: dict[str, list[Any]] = {name: [] for name in skeletons}
    for hinge in hinges:
        for still in _group(fixed, hinge.still, skeletons):
            for moving in _group(fixed, hinge.moving, skeletons):
                _yield(hinge, bodies[still], bodies[moving], rooms)
    return {
        name: replace(each, spared=_meshes(rooms[name], drawing.world(name)))
        for name, each in skeletons.items()
    }


def _group(fixed: Mapping[str, str], link: str, skeletons: Mapping[str, Skeleton]) -> list[str]:
    return [each for each in skeletons if fixed[each] == fixed[link]]


NEAR_MM = 12.0
"""How far about a part others' sweep still matters: struts may go there."""


class _Body:
    """A skeleton's solids in the world at zero."""

    def __init__(self, drawing: Drawing, skeleton: Skeleton) -> None:
        self.name = skeleton.name
        self.world = drawing.world(skeleton.name)
        self.skeleton = skeleton
        self.solids = [self._placed(mesh.manifold) for mesh in skeleton.solids]
        self.blocks = [self._placed(_block(mount, WALL_MM)) for mount in skeleton.servos]
        self.firm = [self._placed(_block(mount, WALL_MM + GAP_MM)) for mount in skeleton.servos]
        self.discs = [self._placed(_disc(mount)) for mount in skeleton.horns]
        self.firm += [rough(from_manifold(disc).vertices, GAP_MM) for disc in self.discs]
        moving = [mesh.moved(self.world) for mesh in (*skeleton.solids, *skeleton.boxes)]
        self.rough = [rough(mesh.vertices, GAP_MM) for mesh in moving]
        self.volume = sum(solid.volume() for solid in self.solids)
        everything = union([*self.solids, *self.blocks, *self.discs])
        low, high = np.reshape(everything.bounding_box(), (2, 3))
        self.near = np.stack([low - NEAR_MM, high + NEAR_MM])

    def _placed(self, solid: Any) -> Any:
        return placed(solid, self.world)

    @property
    def kept(self) -> list[Any]:
        """What others' plastic never takes: pockets, discs and its own half of each pivot."""
        halves = []
        for pivot in self.skeleton.pivots:
            radius = axle(pivot.bearing).radius_mm + FREE_MM
            half = rod(radius, 0.0, 200.0)
            halves.append(
                self._placed(placed(half, frame(pivot.position, pivot.side * pivot.axis)))
            )
        return [*self.blocks, *self.discs, *halves]


def _yield(hinge: Hinge, still: _Body, moving: _Body, rooms: dict[str, list[Any]]) -> None:
    """Add the room that two neighbours need of each other."""
    kept = {body.name: union(body.kept) for body in (still, moving)}
    if moving.firm:
        rooms[still.name].append(swept(moving.firm, hinge, still.near) - kept[still.name])
    if still.firm:
        room = swept(still.firm, hinge, moving.near, back=True)
        rooms[moving.name].append(room - kept[moving.name])
    if not (still.rough and moving.rough):
        return
    to_still = swept(moving.rough, hinge, still.near) - kept[still.name]
    to_moving = swept(still.rough, hinge, moving.near, back=True) - kept[moving.name]
    # A finger that loses half of itself is worse off than a palm that loses as much.
    yields = _lost(still, to_still) <= _lost(moving, to_moving)
    # What does not yield keeps all that is drawn, but grows no struts where the other moves.
    rooms[still.name].append(to_still if yields else to_still - union(still.rough))
    rooms[moving.name].append(to_moving - union(moving.rough) if yields else to_moving)


def _lost(body: _Body, room: Any) -> float:
    """Return how much of what is drawn of a part would be lost to a room, 0 to 1."""
    lost = sum(float((solid ^ room).volume()) for solid in body.solids)
    return float(lost / max(body.volume, 1.0))


def _block(mount: Mount, grow: float) -> Any:
    """Return a servo's case and flange, grown on all sides but that of its horn."""
    which = servo(mount.servo)
    near, far = -which.axis_mm, which.length_mm - which.axis_mm
    if which.flange is not None:
        middle = (near + far) / 2
        near, far = middle - which.flange.length_mm / 2, middle + which.flange.length_mm / 2
    half, low = which.width_mm / 2 + grow, -which.height_mm - grow
    return placed(box((near - grow, -half, low), (far + grow, half, 0.5)), mount.pose)


def _disc(mount: Mount) -> Any:
    """Return the room of the disc that is screwed to a horn."""
    which = servo(mount.servo)
    from print.servo import DISC_MM, disc_radius

    top = which.horn.top_mm
    return placed(rod(disc_radius(which), top - 1.0, top + DISC_MM), mount.pose)


def _meshes(rooms: Sequence[Any], world: Array) -> tuple[Mesh, ...]:
    back = np.asarray(np.linalg.inv(world), dtype=np.float64)
    return tuple(from_manifold(placed(room, back)) for room in rooms if room.volume() > 1.0)
