"""Whether parts that may touch overlap in the home pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.body.check.place import at_link
from morph.body.draft import Draft, DraftLink, Pose, Shape
from morph.body.finding import DescriptionFinding
from morph.body.mesh import Mesh
from morph.body.solids import bounds
from morph.errors import MeshError

SHRUNK = 0.97
"""By how much a shape is shrunk about its middle, so that parts that only touch do not count."""

FEWEST = 3
"""Points of one shape that must lie inside the other."""

MOST_SHAPES, MOST_PAIRS = 2000, 10_000
"""Most shapes, and pairs whose boxes overlap, that are looked at: ten times a humanoid's."""

MOST_POINTS = 1000
"""Most points of a shape that are held against another's convex hull."""

WORK = 120_000
"""Most pairs of a point and a face that are looked at for two shapes."""


@dataclass(frozen=True, kw_only=True)
class Overlap:
    """Two links whose collision shapes overlap at home."""

    one: str
    """The one that stands first in the description."""
    other: str
    """The other."""


@dataclass(frozen=True, kw_only=True)
class PlacedShape:
    """A collision shape in the world at home."""

    link: str
    shape: Shape
    pose: Pose
    box: Array


def overlaps(draft: Draft) -> list[Overlap]:
    """Return the links that overlap at home, though no joint joins them."""
    near = _joined(draft)
    placed = _placed(draft)
    if not 0 < len(placed) <= MOST_SHAPES:
        return []
    low = np.array([part.box[0] for part in placed])
    high = np.array([part.box[1] for part in placed])
    touching = (low[:, None] < high[None]).all(axis=2) & (high[:, None] > low[None]).all(axis=2)
    results: dict[tuple[str, str], Overlap] = {}
    for first, second in np.argwhere(np.triu(touching, 1))[:MOST_PAIRS]:
        one, other = placed[first], placed[second]
        pair = (one.link, other.link)
        if one.link == other.link or pair in results or frozenset(pair) in near:
            continue
        if _reaches(one, other) or _reaches(other, one):
            results[pair] = Overlap(one=one.link, other=other.link)
    return list(results.values())


def self_collisions(draft: Draft, pairs: list[Overlap]) -> list[DescriptionFinding]:
    """Return a finding for each overlap, of which contacts are left out."""
    return [
        DescriptionFinding(
            code="self-collision",
            severity="repaired",
            where=at_link(draft, draft.link(pair.one)),
            what=f"it overlaps {pair.other!r} in the home pose, where contacts would push them",
            done="contacts between the two are left out",
            fix="make the collision shapes smaller, or move the home pose",
        )
        for pair in pairs
    ]


def _joined(draft: Draft) -> set[frozenset[str]]:
    """Return the pairs of links with one moving joint or none between them."""
    head = draft.heads()
    heads = {(head[joint.parent], head[joint.child]) for joint in draft.joints}
    members: dict[str, list[str]] = {}
    for name, top in head.items():
        members.setdefault(top, []).append(name)
    pairs = set()
    for one, other in heads | {(top, top) for top in members}:
        pairs |= {frozenset((a, b)) for a in members[one] for b in members[other]}
    return pairs


def _placed(draft: Draft) -> list[PlacedShape]:
    home = draft.home()
    placed = []
    for link in draft.links:
        for shape in _collides(link):
            box = bounds([shape])
            if box is None or not np.any(box[1] > box[0]):
                continue
            grid: Array = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
            world = home[link.name].apply(grid)
            edges = np.stack([world.min(axis=0), world.max(axis=0)])
            pose = home[link.name].then(shape.pose)
            placed.append(PlacedShape(link=link.name, shape=shape, pose=pose, box=edges))
    return placed


def _collides(link: DraftLink) -> list[Shape]:
    return [s for s in link.shapes if s.role == "collision" and 0.0 not in s.scale]


def _reaches(one: PlacedShape, other: PlacedShape) -> bool:
    """Return whether points of one shape lie inside another."""
    points = one.pose.apply(_surface(one.shape))
    middle = (one.box[0] + one.box[1]) / 2
    points = middle + SHRUNK * (points - middle)
    close = ((points > other.box[0]) & (points < other.box[1])).all(axis=1)
    local = (points[close] - other.pose.position) @ other.pose.rotation
    mesh = other.shape.mesh
    if mesh is not None:
        local = local[:: max(1, len(local) // MOST_POINTS)]
        local = local[_in_hull(mesh, local / np.array(other.shape.scale))]
        most = max(4 * FEWEST, min(300, WORK // len(mesh.faces)))
        local = local[:: max(1, len(local) // most)]
    if len(local) < FEWEST:
        return False
    return bool(_inside(other.shape, local).sum() >= FEWEST)


def _in_hull(mesh: Mesh, points: Array) -> Mask:
    """Return which points lie inside a mesh's convex hull, shape (n,); all if it has none."""
    try:
        hull = mesh.hull
    except MeshError:
        return np.ones(len(points), dtype=bool)
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    within: Mask = (points @ normals.T < np.einsum("fi,fi->f", normals, a)).all(axis=1)
    return within


def _surface(shape: Shape) -> Array:
    """Return points on a shape, in its own frame, shape (n, 3)."""
    if shape.mesh is not None:
        corners = shape.mesh.merged
        centres = corners.vertices[corners.faces].mean(axis=1)
        points: Array = np.concatenate([corners.vertices, centres]) * np.array(shape.scale)
        return points
    if shape.kind == "box":
        grid = np.linspace(-0.5, 0.5, 7)
        cube = np.array(np.meshgrid(grid, grid, grid)).reshape(3, -1).T
        rim = np.abs(cube).max(axis=1) == 0.5
        box: Array = cube[rim] * np.array(shape.size)
        return box
    turns = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns), np.zeros(16)], axis=1)
    radius, length = shape.size[0], shape.size[-1] if shape.kind != "sphere" else 0.0
    if shape.kind == "cylinder":
        heights = np.linspace(-0.5, 0.5, 9) * length
        return np.concatenate([radius * ring + (0, 0, z) for z in heights])
    rises = np.linspace(-np.pi / 2, np.pi / 2, 9)
    rows = [
        radius * (np.cos(a) * ring + (0, 0, np.sin(a))) + (0, 0, np.sign(a) * length / 2)
        for a in rises
    ]
    return np.concatenate(rows)


def _inside(shape: Shape, points: Array) -> Mask:
    """Return which points of a shape's own frame lie inside it, shape (n,)."""
    within: Mask
    if shape.mesh is not None:
        corners = shape.mesh.vertices * np.array(shape.scale)
        within = winding(corners, shape.mesh.faces, points) > 0.75
    elif shape.kind == "box":
        within = np.asarray((np.abs(points) < np.array(shape.size) / 2).all(axis=1))
    elif shape.kind == "sphere":
        away: Array = np.linalg.norm(points, axis=1)
        within = away < shape.size[0]
    else:
        across, half = np.linalg.norm(points[:, :2], axis=1), shape.size[1] / 2
        height = np.abs(points[:, 2])
        if shape.kind == "cylinder":
            within = (across < shape.size[0]) & (height < half)
        else:
            within = np.hypot(across, np.maximum(height - half, 0)) < shape.size[0]
    return within


def winding(vertices: Array, faces: Integers, points: Array) -> Array:
    """Return how often a surface winds about points: 1 inside, 0 outside, shape (n,).

    The solid angles of the faces over 4 pi (Van Oosterom and Strackee 1983,
    IEEE TBME 30(2), eq. 8); for a surface with holes it lies in between (Jacobson et
    al. 2013). Its sign is dropped, so that faces may look inward.
    """
    a, b, c = (vertices[faces[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    top = np.einsum("pfi,pfi->pf", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("pfi,pfi->pf", x, y) for x, y in ((a, b), (b, c), (c, a)))
    angle = 2 * np.arctan2(top, la * lb * lc + ab * lc + bc * la + ca * lb)
    total: Array = np.abs(angle.sum(axis=1)) / (4 * np.pi)
    return total
