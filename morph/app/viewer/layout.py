"""Where each body stands: side by side on one ground, nobody in another's way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.app.viewer.content import Actor
from morph.app.viewer.figure import Figure
from morph.arrays import Array

LOOKED_AT = 60
"""Pictures of a motion from which the room that it takes is measured."""

GAP = 0.35
"""Room between two lanes, by the size of the larger body."""

ELONGATED = 3.0
"""A body that reaches this many times its own size along x moves past its neighbours."""

DEEP = 0.25
"""How far above the ground a swimmer is, by its size."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Places on the ground."""

    places: Array
    """Where each actor's world begins, m, shape (actors, 3)."""
    low: Array
    """Least corner of the room that each actor takes, m, shape (actors, 3)."""
    high: Array
    """Its greatest corner."""
    middle: Array
    """What a camera looks at, m, shape (3,)."""
    radius: float
    """Of what it must see, m."""
    towards: Array
    """From there to the camera, a unit vector, shape (3,)."""


def laid_out(actors: Sequence[Actor]) -> Layout:
    """Return where actors stand; those of one lane begin at one place."""
    lanes = lanes_of(actors)
    boxes = [room(actor) for actor in actors]
    low = np.array([box[0].min(axis=0) for box in boxes])
    high = np.array([box[1].max(axis=0) for box in boxes])
    size = np.array([np.linalg.norm(box[1][0] - box[0][0]) for box in boxes])
    across = 1 if ((high - low)[:, 0] > ELONGATED * size).any() else 0
    places = np.zeros((len(actors), 3))
    edge = 0.0
    for lane in sorted(set(lanes)):
        its = [at for at, each in enumerate(lanes) if each == lane]
        least, most = low[its].min(axis=0), high[its].max(axis=0)
        gap = GAP * float(size[its].max())
        place = np.zeros(3)
        place[across] = edge + gap - least[across]
        place[2] = _lift(actors[its[0]].figure, least[2], float(size[its].max()))
        places[its] = place
        edge = float(place[across] + most[across] + gap)
    low, high = low + places, high + places
    start = np.array([[b[0][0], b[1][0]] for b in boxes]) + places[:, None]
    least, most = start[:, 0].min(axis=0), start[:, 1].max(axis=0)
    towards = np.array([0.75, -0.85, 0.55]) if across else np.array([0.25, -1.0, 0.4])
    return Layout(
        places=places,
        low=low,
        high=high,
        middle=0.5 * (least + most),
        radius=max(0.5 * float(np.linalg.norm(most - least)), 1e-3),
        towards=towards / np.linalg.norm(towards),
    )


def lanes_of(actors: Sequence[Actor]) -> list[int]:
    """Return each actor's lane; those without one come after all others, in order."""
    free = max((actor.lane for actor in actors if actor.lane is not None), default=-1) + 1
    lanes = []
    for actor in actors:
        lanes.append(free if actor.lane is None else actor.lane)
        free += actor.lane is None
    return lanes


def room(actor: Actor) -> tuple[Array, Array]:
    """Return the corners of an actor's upright box in some pictures, (pictures, 3) each.

    Shapes that are fixed to the world count, as a rail does; a floor has no end and does not.
    """
    motion = actor.motion
    which = np.unique(np.linspace(0, motion.pictures - 1, LOOKED_AT).round().astype(int))
    low = np.full((len(which), 3), np.inf)
    high = np.full((len(which), 3), -np.inf)
    for shape in actor.figure.shapes:
        least, most = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        turn = matrices(motion.turn[which, shape.body])
        centre = motion.position[which, shape.body] + turn @ (0.5 * (least + most))
        half = np.abs(turn) @ (0.5 * (most - least))
        low, high = np.minimum(low, centre - half), np.maximum(high, centre + half)
    if not actor.figure.shapes:
        low = motion.position[which].min(axis=1) - 0.05
        high = motion.position[which].max(axis=1) + 0.05
    return low, high


def matrices(turn: Array) -> Array:
    """Return the rotation matrices of unit quaternions, w first: (..., 4) to (..., 3, 3)."""
    w, x, y, z = np.moveaxis(turn, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


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
