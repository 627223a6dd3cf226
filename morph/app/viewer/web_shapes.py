"""Copies of shapes that are light enough for a browser, and few: one a link and colour."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.coarse import coarse
from morph.app.viewer.crease import creased
from morph.arrays import Array, Integers
from morph.body.mesh.solid import Mesh

MOST_FACES = 3000
"""Faces of one shape; more cannot be told apart on a screen."""

MOST_IN_ALL = 60_000
"""Faces of a body: two of them and the page stay within the memory of a small computer."""

LEAST_FACES = 12
"""Faces that every shape keeps: as many as a box has."""

SMALLEST = 1e-9
"""m: what is smaller has nothing to be seen."""


def web_shapes(shapes: Iterable[PictureShape]) -> tuple[PictureShape, ...]:
    """Return what a browser draws instead: lighter, and merged by link and colour.

    What cannot be drawn (no faces, no extent, corners that are no numbers, out of sight by
    its opacity) is left out.
    """
    drawn = [shape for shape in shapes if _can_be_drawn(shape)]
    stubborn: set[bytes] = set()
    light = [
        _light(shape, most, stubborn) for shape, most in zip(drawn, shares(drawn), strict=True)
    ]
    groups: dict[tuple[int, tuple[int, int, int], float], list[PictureShape]] = {}
    for shape in light:
        groups.setdefault((shape.body, shape.colour, shape.opacity), []).append(shape)
    return tuple(_merged(group) for group in groups.values())


def shares(shapes: Sequence[PictureShape]) -> list[int]:
    """Return how many faces each shape may have, so that all fit into `MOST_IN_ALL`.

    The larger a shape's surface, the more; none gets more than it has or `MOST_FACES`, none
    fewer than `LEAST_FACES`, even if thousands of shapes together then exceed the limit.
    """
    if not shapes:
        return []
    wanted = np.array([min(len(shape.faces), MOST_FACES) for shape in shapes])
    if wanted.sum() <= MOST_IN_ALL:
        return [int(each) for each in wanted]
    area = np.array([float(np.linalg.norm(_normals(shape), axis=1).sum()) for shape in shapes])
    low, high = 0.0, float(MOST_FACES / area[area > 0.0].min()) if area.any() else 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _granted(wanted, middle * area).sum() <= MOST_IN_ALL:
            low = middle
        else:
            high = middle
    return [int(each) for each in _granted(wanted, low * area)]


def _granted(wanted: Array, by_area: Array) -> Array:
    return np.asarray(np.minimum(wanted, np.maximum(np.floor(by_area), LEAST_FACES)), dtype=float)


def _normals(shape: PictureShape) -> Array:
    corners = shape.vertices[shape.faces]
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _can_be_drawn(shape: PictureShape) -> bool:
    if not len(shape.faces) or not np.isfinite(shape.vertices).all() or shape.opacity <= 0.0:
        return False
    return bool(np.ptp(shape.vertices, axis=0).max() > SMALLEST)


def _light(shape: PictureShape, most: int, stubborn: set[bytes]) -> PictureShape:
    mesh = coarse(Mesh(vertices=shape.vertices, faces=shape.faces), most, stubborn)
    vertices, faces = creased(mesh.vertices, mesh.faces)
    return replace(shape, vertices=vertices, faces=faces, flat=False)


def _merged(group: Sequence[PictureShape]) -> PictureShape:
    if len(group) == 1:
        return group[0]
    before = np.cumsum([0, *(len(shape.vertices) for shape in group[:-1])])
    faces: Integers = np.concatenate(
        [shape.faces + count for shape, count in zip(group, before, strict=True)]
    )
    return replace(
        group[0], vertices=np.concatenate([shape.vertices for shape in group]), faces=faces
    )
