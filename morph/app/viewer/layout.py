"""Where each body stands: side by side on one ground, nobody in another's way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.app.viewer.content import Actor
from morph.app.viewer.figure import Figure
from morph.app.viewer.framing import FIELD, framed
from morph.app.viewer.layout_request import UnplacedBodies, standing
from morph.app.viewer.rows import in_file, in_rows
from morph.app.viewer.visibility import sight
from morph.arrays import Array, Integers

DEEP = 0.15
"""How far above the ground a swimmer is, by its size."""

FRONT = np.array([0.42, -1.0, 0.42])
"""From a row of bodies to the camera: most swing in the plane that it looks at."""

ABOVE = np.array([0.35, -1.0, 0.8])
"""The same from several rows: from higher up, so that the front ones hide little."""

BESIDE = np.array([0.95, -0.8, 0.6])
"""From bodies that stand or go side by side to the camera, ahead of them."""

OTHER_SIDE = np.array([-1.0, 1.0, 1.0])
"""Turns a place to look from to the other side."""

SPREADS = (1.0, 2.5)
"""How many times the least room bodies of a file keep, where that shows more of them."""

LESS = 0.1
"""How much more must be seen from there, as `sight` tells it."""

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
    rise: Array
    """How much higher it stands in later pictures, m, shape (looked at, actors)."""
    looked: Integers
    """Which pictures those are, shape (looked at,)."""
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
            rise=np.zeros((1, 0)),
            looked=np.zeros(1, dtype=np.int64),
            seen=corners,
            towards=_unit(FRONT),
        )
    stand = standing(actors)
    several = len(stand.groups) > 1
    rows = range(len(stand.groups)) if several else (1,)
    # 0 rows are a file, whose bodies may stand farther from each other.
    orders = [(count, spread) for count in rows for spread in ((1.0,) if count else SPREADS)]
    sides = (np.ones(3), OTHER_SIDE) if several else (np.ones(3),)
    results = [
        _named(stand, order, side * (BESIDE, FRONT, ABOVE)[min(order[0], 2)])
        for order in orders
        for side in sides
    ]
    # From the other side only where that shows clearly more: ahead of bodies is the better one.
    worth = [_sight(stand, each) - LESS * (at % len(sides)) for at, each in enumerate(results)]
    return results[int(np.argmax(worth))]


def title(actor: Actor) -> str:
    """Return what stands above an actor, on one line that is not too long."""
    text = " ".join((actor.figure.name if actor.title is None else actor.title).split())
    return text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "…"


def _named(stand: UnplacedBodies, order: tuple[int, float], towards: Array) -> Layout:
    """Return bodies in so many rows, 0 for a file, with room for their names."""
    towards, pixel = _unit(towards), 0.0
    # How many metres a pixel is follows from the frame, and the frame from how wide names are.
    for _ in range(2):
        result = _arranged(stand, order, towards, pixel)
        distance = framed(result.seen, towards).distance
        pixel = 2.0 * distance * math.tan(0.5 * FIELD) / PICTURE
    return _arranged(stand, order, towards, pixel)


def _sight(stand: UnplacedBodies, result: Layout) -> float:
    """Return how well bodies are seen, at first and later on."""
    place = framed(result.seen, result.towards).position
    label = np.array([LINE, LETTER]) * FIELD / PICTURE
    letters = np.array([len(title(actor)) for actor in stand.actors])
    boxes = stand.boxes + result.places[:, None]
    return float(np.mean([sight(each, place, stand.lanes, label, letters) for each in boxes]))


def _arranged(
    stand: UnplacedBodies, order: tuple[int, float], towards: Array, pixel: float
) -> Layout:
    rooms, groups, (rows, spread) = stand.rooms, stand.groups, order
    low = np.array([each.low.min(axis=0) for each in rooms])
    high = np.array([each.high.max(axis=0) for each in rooms])
    sizes = np.array([each.size for each in rooms])
    least = np.array([low[group].min(axis=0) for group in groups])
    most = np.array([high[group].max(axis=0) for group in groups])
    size = np.array([sizes[group].max() for group in groups])
    letters = [max(len(title(stand.actors[at])) + 2 for at in group) for group in groups]
    widths = pixel * LETTER * np.array(letters)
    if rows:
        flat = in_rows(least, most, size, widths, rows)
    else:
        # All begin beside each other, as in a race, however far each will go.
        cores = np.array([rooms[group[0]].core for group in groups])
        least[:, 0], most[:, 0] = cores[:, 0, 0], cores[:, 1, 0]
        flat = in_file(least, most, size, widths, spread)
    places = np.zeros((len(rooms), 3))
    for lane, group in enumerate(groups):
        figure = stand.actors[group[0]].figure
        places[group, :2] = flat[lane]
        places[group, 2] = _lift(figure, float(least[lane, 2]), float(size[lane]))
    up = np.array([0.0, 0.0, 1.0])
    labels = _labels(stand, towards, pixel) + places + stand.rise[0][:, None] * up
    rise = stand.rise - stand.rise[0]
    tops = labels + (rise.max(axis=0) + LINE * pixel)[:, None] * up
    seen = [outline + place for outline, place in zip(stand.outlines, places, strict=True)]
    return Layout(
        places=places,
        low=low + places,
        high=high + places,
        sizes=sizes,
        labels=labels,
        rise=rise,
        looked=stand.looked,
        seen=np.concatenate((*seen, tops)),
        towards=towards,
    )


def _labels(stand: UnplacedBodies, towards: Array, pixel: float) -> Array:
    """Return where names stand, over their bodies; those of a lane one over the other."""
    labels = np.zeros((len(stand.actors), 3))
    up = np.array([0.0, 0.0, 1.0]) - towards[2] * towards
    for group in stand.groups:
        # Over the links; what is fixed to the world, such as a rail, may reach higher.
        low = np.min([stand.rooms[at].core[0] for at in group], axis=0)
        high = np.max([stand.rooms[at].core[1] for at in group], axis=0)
        top = max(float(stand.rooms[at].high[0, 2]) for at in group)
        middle = 0.5 * (low + high)
        # Who looks down may see the far edge of a body above its middle.
        links = [stand.rooms[at].corners[0, stand.rooms[at].fixed :] for at in group]
        edge = max(((each @ up).max() for each in links if len(each)), default=-math.inf)
        above = max(top, float(edge - middle[:2] @ up[:2]) / float(up[2])) + 0.3 * LINE * pixel
        for at in group:
            labels[at] = *middle[:2], above
            above += LINE * pixel if title(stand.actors[at]) else 0.0
    return labels


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
