"""Volume, centre and spread of a link's shapes, in the link's frame."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.draft import Shape
from morph.errors import MeshError


@dataclass(frozen=True, kw_only=True)
class Solid:
    """A solid of density 1."""

    volume: float
    """m3."""
    com: Array
    """Its centre, m, shape (3,)."""
    inertia: Array
    """About its centre, m5, shape (3, 3)."""


def corners(shape: Shape) -> Array:
    """Return points whose hull holds a shape, in the link's frame, shape (n, 3); maybe none."""
    if shape.kind == "mesh":
        if shape.mesh is None:
            return np.zeros((0, 3))
        mesh = shape.mesh
        points = mesh.merged.vertices * np.array(shape.scale)
    else:
        points = _signs() * _half(shape)
    return shape.pose.apply(points)


def bounds(shapes: Iterable[Shape]) -> Array | None:
    """Return the box around shapes, in the link's frame, shape (2, 3); None without shapes."""
    boxes = [box for shape in shapes if (box := _bounds(shape)) is not None]
    if not boxes:
        return None
    every = np.concatenate(boxes)
    return np.stack([every.min(axis=0), every.max(axis=0)])


def diagonal(box: Array) -> float:
    """Return the length of a box's diagonal, m."""
    return float(np.linalg.norm(box[1] - box[0]))


def away(point: Array, box: Array) -> float:
    """Return the distance of a point from a box, m; 0 inside."""
    outside = np.maximum(np.maximum(box[0] - point, point - box[1]), 0.0)
    return float(np.linalg.norm(outside))


def solid(shape: Shape, *, hull: bool = False) -> Solid | None:
    """Return the solid of a shape; None if it has no volume, or no mesh.

    Args:
        shape: The shape.
        hull: Whether to take a mesh's convex hull even if the mesh is closed;
            of a mesh that is open the hull is taken anyway.
    """
    result = _mesh(shape, hull) if shape.kind == "mesh" else _primitive(shape)
    if result is None or not result.volume > 0:
        return None
    turn = shape.pose.rotation
    return Solid(
        volume=result.volume,
        com=shape.pose.apply(result.com),
        inertia=turn @ result.inertia @ turn.T,
    )


def together(solids: Iterable[Solid]) -> Solid | None:
    """Return several solids as one; where they overlap they count twice."""
    parts = tuple(solids)
    volume = sum(part.volume for part in parts)
    if not volume > 0:
        return None
    com = sum((part.volume * part.com for part in parts), np.zeros(3)) / volume
    inertia = np.zeros((3, 3))
    for part in parts:
        inertia += part.inertia + part.volume * parallel(part.com - com)
    return Solid(volume=volume, com=com, inertia=inertia)


def parallel(offset: Array) -> Array:
    """Return |d|^2 1 - d d', what a unit mass at d adds to an inertia (Steiner's theorem)."""
    moved: Array = offset @ offset * np.eye(3) - np.outer(offset, offset)
    return moved


def _signs() -> Array:
    grid: Array = np.array(np.meshgrid((-1.0, 1.0), (-1.0, 1.0), (-1.0, 1.0)))
    signs: Array = grid.reshape(3, -1).T
    return signs


def _half(shape: Shape) -> Array:
    if shape.kind == "box":
        half: Array = np.abs(np.array(shape.size)) / 2
        return half
    radius = abs(shape.size[0])
    if shape.kind == "sphere":
        return np.full(3, radius)
    ends = radius if shape.kind == "capsule" else 0.0
    return np.array((radius, radius, abs(shape.size[1]) / 2 + ends))


def _bounds(shape: Shape) -> Array | None:
    points = corners(shape)
    if not len(points):
        return None
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _mesh(shape: Shape, hull: bool) -> Solid | None:
    if shape.mesh is None:
        return None
    mesh = shape.mesh
    try:
        if hull or not mesh.consistent or mesh.hollow:
            mesh = mesh.hull
    except MeshError:
        return None
    scaled = mesh.scaled(shape.scale)
    return Solid(volume=abs(scaled.volume), com=scaled.com, inertia=scaled.inertia)


def _primitive(shape: Shape) -> Solid:
    if shape.kind == "box":
        a, b, c = (abs(edge) for edge in shape.size)
        volume = a * b * c
        spread = (b * b + c * c, a * a + c * c, a * a + b * b)
        return _about(volume, volume / 12 * np.array(spread))
    r = abs(shape.size[0])
    ball = 4 / 3 * math.pi * r**3
    if shape.kind == "sphere":
        return _about(ball, np.full(3, 0.4 * ball * r * r))
    length = abs(shape.size[1])
    rod = math.pi * r * r * length
    across = rod * (3 * r * r + length * length) / 12
    along = rod * r * r / 2
    if shape.kind == "capsule":
        # Two half balls, each with its centre 3 r / 8 beyond the rod's end:
        # 2/5 m r^2 + m (l^2 / 4 + 3 l r / 8) across, for both together.
        across += ball * (0.4 * r * r + length * length / 4 + 3 * length * r / 8)
        along += 0.4 * ball * r * r
        rod += ball
    return _about(rod, np.array((across, across, along)))


def _about(volume: float, spread: Array) -> Solid:
    return Solid(volume=volume, com=np.zeros(3), inertia=np.diag(spread))
