"""Room that neighbours sweep: what each part must keep out of, and which of two gives way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.fabrication.drawing import Drawing
from morph.fabrication.rigid import roots
from morph.fabrication.sweep import rough, swept
from morph.print.fit_pivot import FREE_MM, axle
from morph.print.joint_sweep import Sweep
from morph.print.mesh import Mesh, from_manifold
from morph.print.part import Hinge
from morph.print.servo import DISC_MM, case, disc_radius, servo, turning_room
from morph.print.skeleton import Mount, Skeleton
from morph.print.solid import box, frame, placed, rod, union

GAP_MM = 0.6
"""Room between what moves and what stays."""

WALL_MM = 3.0
"""Walls of a servo's pocket or a tray with their play: others keep out of these too."""

NEAR_MM = 12.0
"""How far about a part others' sweep still matters: struts may go there."""


def spared(
    drawing: Drawing, skeletons: Mapping[str, Skeleton], hinges: Sequence[Hinge]
) -> dict[str, Skeleton]:
    """Return skeletons with the room that their neighbours need.

    All plastic yields to what is bought and to the discs on horns; drawn plastic yields to pockets
    and trays too. Of two walls, and of the drawn plastic of two neighbours, that yields which
    loses less. Only neighbours are looked at, and only as far as what is bought lets them turn.
    """
    fixed = roots(drawing.robot)
    bodies = {name: _Body(drawing, each) for name, each in skeletons.items()}
    rooms: dict[str, list[tuple[int, Any]]] = {name: [] for name in skeletons}
    for hinge in hinges:
        for still in _group(fixed, hinge.still, skeletons):
            for moving in _group(fixed, hinge.moving, skeletons):
                _yield(hinge, bodies[still], bodies[moving], rooms)
    return {
        name: replace(each, spared=_meshes(_ranked(rooms[name]), drawing.world(name)))
        for name, each in skeletons.items()
    }


def _group(fixed: Mapping[str, str], link: str, skeletons: Mapping[str, Skeleton]) -> list[str]:
    return [each for each in skeletons if fixed[each] == fixed[link]]


class _Body:
    """A skeleton's solids in the world at zero."""

    def __init__(self, drawing: Drawing, skeleton: Skeleton) -> None:
        self.name = skeleton.name
        self.world = drawing.world(skeleton.name)
        self.skeleton = skeleton
        servos = [servo(mount.servo) for mount in skeleton.servos]
        held = zip(servos, skeleton.servos, strict=True)
        self.bought = [self._placed(placed(case(s).manifold, mount.pose)) for s, mount in held]
        self.bought += [self._placed(mesh.manifold) for mesh in skeleton.boxes]
        self.solids = [self._placed(mesh.manifold) for mesh in skeleton.solids]
        self.blocks = [self._placed(_block(mount, WALL_MM)) for mount in skeleton.servos]
        self.discs = [self._placed(_disc(mount)) for mount in skeleton.horns]
        boxes = [mesh.moved(self.world).vertices for mesh in skeleton.boxes]
        self.hard = [self._placed(_block(mount, GAP_MM)) for mount in skeleton.servos]
        self.hard += [rough(corners, GAP_MM) for corners in boxes]
        self.horns = [self.world @ mount.pose for mount in skeleton.horns]
        self.turning = [self._placed(_turning(mount)) for mount in skeleton.horns]
        self.walls = [self._placed(_block(mount, WALL_MM + GAP_MM)) for mount in skeleton.servos]
        self.walls += [rough(corners, WALL_MM + GAP_MM) for corners in boxes]
        drawn = [mesh.moved(self.world).vertices for mesh in skeleton.solids]
        self.rough = [rough(corners, GAP_MM) for corners in drawn]
        self.volume = sum(solid.volume() for solid in self.solids)
        everything = union([*self.solids, *self.blocks, *self.discs])
        low, high = np.reshape(everything.bounding_box(), (2, 3))
        self.near = np.stack([low - NEAR_MM, high + NEAR_MM])

    def _placed(self, solid: Any) -> Any:
        return placed(solid, self.world)

    @property
    def kept(self) -> Any:
        """What other parts' plastic never takes: discs, and its own half of each pivot."""
        return union([*self.discs, self.halves])

    @property
    def halves(self) -> Any:
        """Its own half of each pivot."""
        halves = []
        for pivot in self.skeleton.pivots:
            radius = axle(pivot.bearing).radius_mm + FREE_MM
            half = rod(radius, 0.0, 200.0)
            halves.append(
                self._placed(placed(half, frame(pivot.position, pivot.side * pivot.axis)))
            )
        return union(halves)


def _yield(
    hinge: Hinge, still: _Body, moving: _Body, rooms: dict[str, list[tuple[int, Any]]]
) -> None:
    """Add the room that two neighbours need of each other."""
    hinge = _limited(hinge, still, moving)

    def room(of: str, on: _Body) -> Any:
        """Return what solids of a kind sweep of the other of the two, as that one sees it."""
        other, back = (moving, False) if on is still else (still, True)
        solids = getattr(other, of)
        round_ = []
        if of == "hard":
            about = [_about(pose, hinge) for pose in other.horns]
            round_ = [disc for disc, yes in zip(other.turning, about, strict=True) if yes]
            solids = solids + [d for d, yes in zip(other.turning, about, strict=True) if not yes]
        return union([*round_, swept(solids, hinge, on.near, back=back)])

    pockets = {body.name: union(body.blocks) for body in (still, moving)}
    walls = [(on, room("walls", on) - on.kept) for on in (still, moving)]
    # Of two walls that want one place, one stays whole.
    yields = min(walls, key=lambda each: _share(pockets[each[0].name], each[1]))[0]
    for on, taken in walls:
        rooms[on.name].append((0, room("hard", on) - on.halves))
        rooms[on.name].append((1, taken if on is yields else taken - pockets[on.name]))
    drawn = [(on, room("rough", on) - on.kept - pockets[on.name]) for on in (still, moving)]
    # A finger that loses half of itself is worse off than a palm that loses as much.
    yields = min(drawn, key=lambda each: _lost(each[0], each[1]))[0]
    for on, taken in drawn:
        # What does not yield keeps all that is drawn, but grows no struts where the other moves.
        rooms[on.name].append((2, taken if on is yields else taken - union(on.rough)))


def _limited(hinge: Hinge, still: _Body, moving: _Body) -> Hinge:
    """Return a joint with the range that what is bought leaves it: beyond, room is no use."""
    sides = [[(body.name, solid) for solid in body.bought] for body in (still, moving)]
    if not all(sides):
        return hinge
    sweep = Sweep(hinge, *sides)
    ends = sorted(sweep.free_to(end)[0] for end in (hinge.low, hinge.high))
    return replace(hinge, low=ends[0], high=ends[1])


def _about(pose: Array, hinge: Hinge) -> bool:
    """Return whether a disc lies about a joint's axis, so that it sweeps nothing but itself."""
    off = np.cross(pose[:3, 3] - hinge.position, hinge.axis)
    along = np.cross(pose[:3, 2], hinge.axis)
    return bool(np.linalg.norm(off) < 0.1 and np.linalg.norm(along) < 1e-3)


def _share(walls: Any, room: Any) -> float:
    """Return how much of a part's pockets a room would take, 0 to 1."""
    return float((walls ^ room).volume()) / max(float(walls.volume()), 1.0)


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
    top = which.horn.top_mm
    return placed(rod(disc_radius(which), top - 1.0, top + DISC_MM), mount.pose)


def _turning(mount: Mount) -> Any:
    """Return where that disc turns, from the face of what is under it."""
    return placed(turning_room(servo(mount.servo)), mount.pose)


def _ranked(rooms: Sequence[tuple[int, Any]]) -> list[Any]:
    """Return rooms, those first that matter most."""
    return [room for _, room in sorted(rooms, key=lambda each: each[0])]


def _meshes(rooms: Sequence[Any], world: Array) -> tuple[Mesh, ...]:
    back = np.asarray(np.linalg.inv(world), dtype=np.float64)
    return tuple(from_manifold(placed(room, back)) for room in rooms if room.volume() > 1.0)
