"""Where each body stands: side by side on one ground, nobody in another's way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import mujoco
import numpy as np

from morph.app.viewer.content import Actor
from morph.app.viewer.figure import Figure
from morph.app.viewer.framing import FIELD, framed
from morph.app.viewer.room import Room, looked_at, room
from morph.app.viewer.rows import in_file, in_rows
from morph.arrays import Array

ELONGATED = 3.0
"""A body that reaches this many times its own size along x moves past its neighbours."""

STRAYS = 0.6
"""What leaves its first box by more than this, by its size, may leave the picture."""

DEEP = 0.35
"""How far above the ground a swimmer is, by its size."""

FRONT = np.array([0.42, -1.0, 0.42])
"""From a row of bodies to the camera: most swing in the plane that it looks at."""

BESIDE = np.array([0.95, -0.8, 0.6])
"""From bodies that stand or go side by side to the camera, ahead of them."""

HIDDEN = 0.9
"""A body that is hidden by others is worth this much more distance, once more."""

LETTER, LINE, PICTURE = 7.0, 24.0, 760.0
"""Width of a letter and height of a label, and height of a picture, pixels."""

MOST_LETTERS = 28
"""A longer name is cut."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Places on the ground."""

    places: Array
    """Where each actor's world begins, m, shape (actors, 3)."""
    low: Array
    """Least corner of the room that each actor takes, m, shape (actors, 3)."""
    high: Array
    """Its greatest corner."""
    sizes: Array
    """How large each actor is, m, shape (actors,)."""
    labels: Array
    """Where the name of each actor stands in the first picture, m, shape (actors, 3)."""
    seen: Array
    """What a camera must see while it goes with the bodies, m, shape (points, 3)."""
    towards: Array
    """From there to the camera, a unit vector, shape (3,)."""

    @property
    def middle(self) -> Array:
        """The middle of what must be seen, m, shape (3,)."""
        return np.asarray(0.5 * (self.seen.min(axis=0) + self.seen.max(axis=0)))

    @property
    def radius(self) -> float:
        """Of what must be seen, m."""
        return max(0.5 * float(np.linalg.norm(np.ptp(self.seen, axis=0))), 1e-3)


def laid_out(actors: Sequence[Actor]) -> Layout:
    """Return where actors stand; those of one lane begin at one place.

    Bodies that go past their neighbours stand side by side across their way. Others stand in
    the rows, or the file (0 rows), that show them largest and hide least.
    """
    if not actors:
        nothing = np.zeros((0, 3))
        corners = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]])
        return Layout(
            places=nothing,
            low=nothing,
            high=nothing,
            sizes=np.zeros(0),
            labels=nothing,
            seen=corners,
            towards=_unit(FRONT),
        )
    pictures = looked_at(actors)
    rooms = [room(actor, pictures) for actor in actors]
    lanes = lanes_of(actors)
    several = len(set(lanes)) > 1
    if several and any(each.travels(ELONGATED) for each in rooms):
        return _named(actors, rooms, lanes, 0)
    ways = range(len(set(lanes))) if several else (1,)
    return min(
        (_named(actors, rooms, lanes, rows) for rows in ways),
        key=lambda found: _cost(found, rooms, lanes),
    )


def lanes_of(actors: Sequence[Actor]) -> list[int]:
    """Return each actor's lane; those without one come after all others, in order."""
    free = max((actor.lane for actor in actors if actor.lane is not None), default=-1) + 1
    lanes = []
    for actor in actors:
        lanes.append(free if actor.lane is None else actor.lane)
        free += actor.lane is None
    return lanes


def title(actor: Actor) -> str:
    """Return what stands above an actor, on one line that is not too long."""
    text = " ".join((actor.figure.name if actor.title is None else actor.title).split())
    return text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "…"


def _named(actors: Sequence[Actor], rooms: Sequence[Room], lanes: list[int], rows: int) -> Layout:
    """Return bodies in so many rows, 0 for a file, with room for their names."""
    pixel = 0.0
    # How many metres a pixel is follows from the frame, and the frame from how wide names are.
    for _ in range(2):
        found = _arranged(actors, rooms, lanes, rows, pixel)
        distance = framed(found.seen, found.towards).distance
        pixel = 2.0 * distance * math.tan(0.5 * FIELD) / PICTURE
    return _arranged(actors, rooms, lanes, rows, pixel)


def _cost(found: Layout, rooms: Sequence[Room], lanes: list[int]) -> float:
    """Return how badly bodies are seen: by how far the farthest is, and what hides them, m."""
    place = framed(found.seen, found.towards).position
    low = np.array([each.low[0] for each in rooms]) + found.places
    high = np.array([each.high[0] for each in rooms]) + found.places
    far = np.linalg.norm(0.5 * (low + high) - place, axis=1)
    least, most = (
        np.array(each) for each in zip(*map(_pictured, low - place, high - place), strict=True)
    )
    hidden = np.zeros(len(lanes))
    for at, lane in enumerate(lanes):
        for other, its in enumerate(lanes):
            if its != lane and far[other] < far[at]:
                both = np.minimum(most[at], most[other]) - np.maximum(least[at], least[other])
                own = float(np.prod(most[at] - least[at])) or 1.0
                hidden[at] += float(np.prod(np.maximum(both, 0.0))) / own
    return float(far.max() * (1.0 + HIDDEN * np.minimum(hidden, 1.0).mean()))


def _pictured(low: Array, high: Array) -> tuple[Array, Array]:
    """Return the corners, about, of a box as a camera at 0 pictures it: azimuth, elevation."""
    x, y, z = np.stack((low, high))[np.array(list(product((0, 1), repeat=3))), np.arange(3)].T
    middle = 0.5 * (low + high)
    turn = np.arctan2(middle[1], middle[0])
    across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    angles = np.stack((turn + np.arctan2(across[1], across[0]), np.arctan2(z, np.hypot(x, y))))
    return angles.min(axis=1), angles.max(axis=1)


def _arranged(
    actors: Sequence[Actor], rooms: Sequence[Room], lanes: list[int], rows: int, pixel: float
) -> Layout:
    low = np.array([each.low.min(axis=0) for each in rooms])
    high = np.array([each.high.max(axis=0) for each in rooms])
    sizes = np.array([each.size for each in rooms])
    groups = [[at for at, its in enumerate(lanes) if its == lane] for lane in sorted(set(lanes))]
    least = np.array([low[group].min(axis=0) for group in groups])
    most = np.array([high[group].max(axis=0) for group in groups])
    size = np.array([sizes[group].max() for group in groups])
    letters = [max(len(title(actors[at])) + 2 for at in group) for group in groups]
    widths = pixel * LETTER * np.array(letters)
    flat = in_rows(least, most, size, widths, rows) if rows else in_file(least, most, size, widths)
    places = np.zeros((len(actors), 3))
    for lane, group in enumerate(groups):
        places[group, :2] = flat[lane]
        places[group, 2] = _lift(actors[group[0]].figure, float(least[lane, 2]), float(size[lane]))
    labels = _labels(actors, rooms, groups, pixel) + places
    tops = labels + np.array([0.0, 0.0, LINE * pixel])
    return Layout(
        places=places,
        low=low + places,
        high=high + places,
        sizes=sizes,
        labels=labels,
        seen=np.concatenate((_seen(rooms, places), tops)),
        towards=_unit(FRONT if rows else BESIDE),
    )


def _labels(
    actors: Sequence[Actor], rooms: Sequence[Room], groups: list[list[int]], pixel: float
) -> Array:
    """Return where names stand, over their bodies; those of a lane one over the other."""
    labels = np.zeros((len(actors), 3))
    for group in groups:
        low = np.min([rooms[at].low[0] for at in group], axis=0)
        high = np.max([rooms[at].high[0] for at in group], axis=0)
        above = float(high[2]) + 0.3 * LINE * pixel
        for at in group:
            labels[at] = *(0.5 * (low + high))[:2], above
            above += LINE * pixel if title(actors[at]) else 0.0
    return labels


def _seen(rooms: Sequence[Room], places: Array) -> Array:
    """Return corners of what bodies take up while a camera goes with their mean way."""
    mean = np.mean([each.gone for each in rooms], axis=0)
    mean = np.concatenate((mean, np.zeros((len(mean), 1))), axis=1)
    corners = []
    for each, place in zip(rooms, places, strict=True):
        stray = STRAYS * each.size
        corners.append(np.maximum((each.low - mean).min(axis=0), each.low[0] - stray) + place)
        corners.append(np.minimum((each.high - mean).max(axis=0), each.high[0] + stray) + place)
    pairs = np.array(corners).reshape(-1, 2, 3)
    which = np.array(list(product((0, 1), repeat=3)))
    return np.asarray(pairs[:, which, np.arange(3)].reshape(-1, 3))


def _lift(figure: Figure, lowest: float, size: float) -> float:
    """Return how far a body's world is raised, so that its own floor is the common ground."""
    model = figure.model
    plane = mujoco.mjtGeom.mjGEOM_PLANE.value
    floors = [
        float(model.geom_pos[geom, 2])
        for geom in range(model.ngeom)
        if model.geom_type[geom] == plane and model.geom_bodyid[geom] == 0
    ]
    # An effect may put a floor where nothing touches it, far below.
    near = [floor for floor in floors if floor > lowest - 2.0 * size]
    if near and not figure.wet:
        return -max(near)
    return -lowest + (DEEP * size if figure.wet else 0.0)


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
