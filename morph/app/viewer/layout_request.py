"""Input of the layout: the bounds of each body and what must be visible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.app.viewer.content import Actor
from morph.app.viewer.motion import RATE
from morph.app.viewer.swept_bounds import EIGHT, SweptBounds, looked_at, room
from morph.app.viewer.visibility import outline
from morph.arrays import Array, Integers

STRAYS = 0.6
"""What leaves its first box by more than this, by its size, may leave the picture."""

RAIL = 0.3
"""Of what is fixed to the world, as much is seen beyond the links, by their size."""

MOMENTS = 5
"""Pictures of a motion in which it is judged how well bodies are seen."""

CALM = 0.4
"""s for which a name stays as high as its body was: nobody reads what bobs."""


@dataclass(frozen=True, kw_only=True)
class UnplacedBodies:
    """Bodies before they have a place."""

    actors: Sequence[Actor]
    """The bodies."""
    rooms: Sequence[SweptBounds]
    """The room that each takes."""
    outlines: Sequence[Array]
    """What of each actor must be seen, in its own world, m, each of shape (points, 3)."""
    looked: Integers
    """The pictures from which it was measured."""
    lanes: list[int]
    """Each actor's lane."""
    groups: list[list[int]]
    """Numbers of the actors of each lane."""
    rise: Array
    """How much higher the top of each lane is than at first, m, shape (looked at, actors)."""
    boxes: Array
    """Corners of the upright box of each actor's links as the camera goes along with them, now
    and then, m, shape (pictures, actors, 2, 3)."""


def standing(actors: Sequence[Actor]) -> UnplacedBodies:
    """Return what is to be laid out of some actors, at least one."""
    looked = looked_at(actors)
    rooms = [room(actor, looked) for actor in actors]
    lanes = lanes_of(actors)
    groups = [[at for at, its in enumerate(lanes) if its == lane] for lane in sorted(set(lanes))]
    rise = np.zeros((len(looked), len(actors)))
    for group in groups:
        size = max(rooms[at].size for at in group)
        highest = np.max([rooms[at].rise for at in group], axis=0)
        rise[:, group] = _calm(np.clip(highest, -size, size), looked)[:, None]
    return UnplacedBodies(
        actors=actors,
        rooms=rooms,
        outlines=_outlines(rooms),
        looked=looked,
        lanes=lanes,
        groups=groups,
        rise=rise,
        boxes=_boxes(rooms),
    )


def _boxes(rooms: Sequence[SweptBounds]) -> Array:
    mean = _mean(rooms)
    results = []
    for at in np.linspace(0, len(mean) - 1, MOMENTS).round().astype(int):
        links = [each.corners[at, each.fixed :] - mean[at] for each in rooms]
        results.append(
            [
                (points.min(axis=0), points.max(axis=0)) if at and len(points) else each.core
                for points, each in zip(links, rooms, strict=True)
            ]
        )
    return np.array(results)


def _mean(rooms: Sequence[SweptBounds]) -> Array:
    """Return how far bodies have gone on the whole, m, shape (looked at, 3)."""
    mean = np.mean([each.gone for each in rooms], axis=0)
    return np.concatenate((mean, np.zeros((len(mean), 1))), axis=1)


def _calm(rise: Array, looked: Integers) -> Array:
    """Return the greatest of what is near in time, smoothed."""
    away = np.abs(looked[:, None] - looked) / RATE
    highest = np.where(away <= CALM, rise, -np.inf).max(axis=1)
    near = away <= CALM
    smooth = (near * highest).sum(axis=1) / near.sum(axis=1)
    return np.asarray(smooth)


def lanes_of(actors: Sequence[Actor]) -> list[int]:
    """Return each actor's lane; those without one come after all others, in order."""
    free = max((actor.lane for actor in actors if actor.lane is not None), default=-1) + 1
    lanes = []
    for actor in actors:
        lanes.append(free if actor.lane is None else actor.lane)
        free += actor.lane is None
    return lanes


def _outlines(rooms: Sequence[SweptBounds]) -> list[Array]:
    """Return the outline of what bodies take up while a camera goes with their mean way."""
    mean = _mean(rooms)
    results = []
    for each in rooms:
        stray, rail = STRAYS * each.size, RAIL * each.size
        points = each.corners - mean[:, None]
        moving = points[:, each.fixed :].reshape(-1, 3)
        near = np.clip(moving, each.core[0] - stray, each.core[1] + stray)
        near = np.concatenate((near, each.core[EIGHT, np.arange(3)]))
        # Of a long rail as much is seen as its cart makes use of.
        fixed = points[:, : each.fixed].reshape(-1, 3)
        fixed = np.clip(fixed, near.min(axis=0) - rail, near.max(axis=0) + rail)
        results.append(outline(np.concatenate((near, fixed))))
    return results
