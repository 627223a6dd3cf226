"""Parts as bodies on the stage: taken apart, put together, or on the beds of a printer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.content import Actor, Colour, Moment
from morph.app.viewer.figure import Figure
from morph.app.viewer.motion import RATE, MotionFrames
from morph.app.viewer.printed.skin import MM, Skin
from morph.arrays import Array
from morph.body.robot import Robot
from morph.print.explode import Explosion
from morph.print.job import Plate
from morph.print.part import Part

PARTING, HELD, CLOSING, CLOSED = 2.0, 1.5, 1.5, 0.5
"""How long a body takes to come apart, stays so, comes together and stays so, s."""

STEP, LONGEST = 0.9, 20.0
"""How long a step of putting together takes, and all of them at most, s."""

BED: Colour = (92, 100, 110)
"""Of a printer's bed."""

BED_MM = 2.0
"""How thick it is drawn."""

Colours = Mapping[str, "Array | Colour"]
"""Of each part by its name: one for all of it, or one a corner."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedCopy:
    """One copy of a part in its first place."""

    name: str
    """What the link is called that stands for it."""
    skin: Skin
    """What is drawn of it."""
    pose: Array
    """From the part's frame into the world's, mm, shape (4, 4)."""


def copy_name(part: Part, copy: int) -> str:
    """Return what a copy of a part is called."""
    return f"{part.name} {copy + 1}" if part.count > 1 else part.name


def part_of(name: str) -> str:
    """Return the part that a copy is of; the name of a part has no space."""
    return name.partition(" ")[0]


def apart(
    robot: Robot, skins: Mapping[str, Skin], explosion: Explosion, colours: Colours, title: str
) -> tuple[Actor, tuple[Moment, ...]]:
    """Return the body that comes apart and together, and when it is which."""
    time = np.arange(0.0, PARTING + HELD + CLOSING + CLOSED, 1.0 / RATE)
    opened = smooth(time / PARTING)
    closed = smooth((time - PARTING - HELD) / CLOSING)
    factor = np.asarray(opened - closed)
    copies, offsets = _copies(skins, explosion)
    actor = _actor(robot, copies, offsets, np.tile(factor[:, None], len(copies)), colours, title)
    return actor, (Moment(time=0.0, title="together"), Moment(time=PARTING, title="apart"))


def together(
    robot: Robot, skins: Mapping[str, Skin], explosion: Explosion, colours: Colours, title: str
) -> tuple[Actor, tuple[Moment, ...]]:
    """Return the body as it is put together link by link, and when each comes."""
    copies, offsets = _copies(skins, explosion)
    step = min(STEP, LONGEST / max(len(explosion.links), 1))
    begins = {link: step * (at + 0.5) for at, link in enumerate(explosion.links)}
    time = np.arange(0.0, step * (len(explosion.links) + 1.5), 1.0 / RATE)
    start = np.array([begins[link] for link in _links(skins, explosion)])
    factor = 1.0 - smooth((time[:, None] - start) / (0.8 * step))
    moments = tuple(
        Moment(time=begin, title=link.replace("_", " ")) for link, begin in begins.items()
    )
    return _actor(robot, copies, offsets, factor, colours, title), moments


def when(factor: float) -> float:
    """Return when the body that comes apart is so far apart, s."""
    share = np.linspace(0.0, 1.0, 201)
    return float(PARTING * np.interp(factor, smooth(share), share))


def how_far(time: float) -> float:
    """Return how far apart the body is at a time, 0 to 1."""
    opened = smooth(np.array(time / PARTING))
    return float(opened - smooth(np.array((time - PARTING - HELD) / CLOSING)))


def smooth(share: Array) -> Array:
    """Return how far a motion is that begins and ends gently: 3 x^2 - 2 x^3, from 0 to 1."""
    x = np.clip(share, 0.0, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))


def on_bed(
    robot: Robot,
    plate: Plate,
    bed_mm: Sequence[float],
    skins: Mapping[str, Skin],
    colours: Colours,
    title: str,
) -> Actor:
    """Return a plate: the bed, and every copy on it as it is printed."""
    copies = [
        PlacedCopy(
            name=copy_name(skins[laid.part].part, laid.copy),
            skin=skins[laid.part],
            pose=laid.pose,
        )
        for laid in plate.laid
        if laid.part in skins
    ]
    still = np.zeros((len(copies), 3)), np.zeros((1, len(copies)))
    return _actor(robot, copies, *still, colours, title, bed_mm)


def _copies(skins: Mapping[str, Skin], explosion: Explosion) -> tuple[list[PlacedCopy], Array]:
    copies, offsets = [], []
    for name, skin in skins.items():
        for copy, placement in enumerate(skin.part.placements):
            standing = PlacedCopy(name=copy_name(skin.part, copy), skin=skin, pose=placement.world)
            copies.append(standing)
            offsets.append(explosion.offsets.get((name, copy), np.zeros(3)))
    return copies, np.array(offsets).reshape(-1, 3)


def _links(skins: Mapping[str, Skin], explosion: Explosion) -> list[str]:
    return [placement.link for skin in skins.values() for placement in skin.part.placements]


def _actor(
    robot: Robot,
    copies: Sequence[PlacedCopy],
    offsets: Array,
    factor: Array,
    colours: Colours,
    title: str,
    bed_mm: Sequence[float] = (),
) -> Actor:
    """Return copies that move along their offsets, mm, by a factor, shape (pictures, copies)."""
    names = [*(copy.name for copy in copies), *(["bed"] if bed_mm else [])]
    spec = mujoco.MjSpec()
    for name in names:
        spec.worldbody.add_body(name=name)
    start = np.array([copy.pose[:3, 3] for copy in copies]).reshape(-1, 3)
    position = np.zeros((len(factor), len(names) + 1, 3))
    position[:, 1 : len(copies) + 1] = MM * (start + factor[:, :, None] * offsets)
    turn = np.zeros((len(factor), len(names) + 1, 4))
    # A copy's turn is in its corners: so a mirrored one is drawn as any other.
    turn[:, :, 0] = 1.0
    shapes = [_shape(at, copy, colours) for at, copy in enumerate(copies, 1)]
    if bed_mm:
        shapes.append(_bed(len(names), bed_mm))
    figure = Figure(robot=robot, name=title, model=spec.compile(), shapes=tuple(shapes))
    return Actor(figure=figure, motion=MotionFrames(position=position, turn=turn), title=title)


def _bed(body: int, bed_mm: Sequence[float]) -> PictureShape:
    """Return a printer's bed, whose top is at 0 and whose corner is the origin."""
    from trimesh import creation

    wide, deep = (float(each) for each in bed_mm[:2])
    box = creation.box((wide, deep, BED_MM))
    corners = np.asarray(box.vertices) + np.array((0.5 * wide, 0.5 * deep, -0.5 * BED_MM))
    return PictureShape(
        body=body,
        vertices=MM * corners,
        faces=np.asarray(box.faces, dtype=np.int64),
        colour=BED,
        opacity=1.0,
        flat=True,
    )


def _shape(body: int, copy: PlacedCopy, colours: Colours) -> PictureShape:
    turn, skin = copy.pose[:3, :3], copy.skin
    faces = skin.faces if np.linalg.det(turn) > 0.0 else skin.faces[:, ::-1].copy()
    given = colours[skin.part.name]
    plain = given if isinstance(given, tuple) else (0, 0, 0)
    return PictureShape(
        body=body,
        vertices=MM * (skin.vertices @ turn.T),
        faces=faces,
        colour=plain,
        opacity=1.0,
        flat=False,
        colours=None if isinstance(given, tuple) else np.rint(given).astype(np.uint8),
    )
