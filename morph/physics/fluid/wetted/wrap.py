"""A watertight skin around shapes that are open, torn or in pieces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.body.mesh import Mesh
from morph.physics.fluid.tensor.manifold import from_manifold
from morph.physics.fluid.tensor.remesh import remeshed

RADII = (0.0, 0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.12)
"""Radii of the ball that must not get in, as parts of the greatest extent, tried in turn."""

SEALED = 1.5
"""Growth of the volume, from one radius to the next, that says that an inside was sealed."""

GAIN = 0.1
"""And the least that it then grows by, as a part of the convex hull's volume."""

TRIED = 48
"""Cells along the greatest extent on which the radii are tried."""

CRUMB = 0.01
"""Part of the volume below which a separate piece of a wrap is left out."""

FINE = 2.0
"""Edges of the skin when it is cut, in steps of the grid."""

TRIES, BLUR = 6, 0.5
"""How often a skin is cut, and the blur at first, in steps: half as much more each time."""

SHY = 0.1
"""How deep under the skin it is cut, in steps of the grid."""

SHRUNK = 0.1
"""Part of the volume that cutting may lose and growing gives back; more is another shape."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Distances on a regular grid of points."""

    origin: Array
    """Its first point, m, shape (3,)."""
    step: float
    """Distance of neighbouring points, m."""
    values: Array
    """m, shape (a, b, c); positive inside."""


def sealing_radius(shapes: tuple[Mesh, ...]) -> float:
    """Return the radius of the ball that seals the openings of shapes, m.

    The smallest ball is taken whose closing encloses far more than that of the
    ball before it: from there on the inside is no longer reached. Shapes of
    which no ball seals an inside get a radius of 0, and stay as they are.
    """
    extent = _extent(shapes)
    distance = _distance(shapes, TRIED, max(RADII) * extent)
    points = np.concatenate([shape.vertices for shape in shapes])
    most = Mesh(vertices=points, faces=_any(len(points))).hull.volume
    before = None
    for part in RADII:
        volume = _volume(_closed(distance, part * extent))
        if before is not None and volume > before * SEALED and volume > before + GAIN * most:
            return part * extent
        before = volume
    return 0.0


def wrapped(shapes: tuple[Mesh, ...], *, cells: int, radius: float, panels: int) -> Mesh | None:
    """Return a watertight solid that shapes seem to bound; None if they bound nothing.

    A ball of the given radius rolls over the shapes from outside; what it does
    not reach is inside (morphological closing: Serra 1982, "Image Analysis and
    Mathematical Morphology", on distances rather than cells). Its boundary is
    cut by marching tetrahedra.

    Args:
        shapes: What is to be wrapped, m.
        cells: Points of the grid along the greatest extent.
        radius: Of the ball, m; see `sealing_radius`.
        panels: About how many triangles the skin is to have.
    """
    radius = max(radius, _extent(shapes) / cells)
    grid = _closed(_distance(shapes, cells, radius), radius)
    if not (grid.values > 0).any():
        return None
    volume, blur = _volume(grid), BLUR
    for _ in range(TRIES):
        skin = _skin(_blurred(grid, blur), FINE * grid.step)
        if skin is None or _is_sheet(skin, grid.step):
            return None
        result = _without_crumbs(skin)
        # A skin may touch itself where it has details finer than its edges.
        if result.consistent:
            result = remeshed(result, panels)
            off = abs(float(np.log(volume / result.volume)))
            return _of_volume(result, volume) if off < SHRUNK else result
        blur *= 1.5
    return None


def _extent(shapes: tuple[Mesh, ...]) -> float:
    bounds = np.stack([shape.bounds for shape in shapes])
    return float((bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)).max())


def _distance(shapes: tuple[Mesh, ...], cells: int, room: float) -> Grid:
    """Return the distance to the nearest point of the shapes, with some room around them, m."""
    from scipy.ndimage import distance_transform_edt

    extent = _extent(shapes)
    step = extent / cells
    points = np.concatenate([_points(shape, step / 2.0) for shape in shapes])
    margin = int(np.ceil(room / step)) + 3
    origin = points.min(axis=0) - margin * step
    cell = np.round((points - origin) / step).astype(np.int64)
    size = tuple(int(count) for count in cell.max(axis=0) + margin + 1)
    flat = np.ravel_multi_index(tuple(cell.T), size)
    count = np.bincount(flat, minlength=int(np.prod(size)))
    taken = np.flatnonzero(count)
    mean = np.stack([np.bincount(flat, points[:, i])[taken] / count[taken] for i in range(3)], 1)
    where = np.zeros(len(count), dtype=np.int64)
    where[taken] = np.arange(len(taken))
    nearest = distance_transform_edt(
        count.reshape(size) == 0, return_distances=False, return_indices=True
    )
    near = mean[where[np.ravel_multi_index(tuple(nearest), size)]]
    places = origin + step * np.moveaxis(np.indices(size), 0, -1)
    return Grid(origin=origin, step=step, values=np.linalg.norm(places - near, axis=-1))


def _points(shape: Mesh, spacing: float) -> Array:
    """Return points all over a surface, no farther apart than the spacing; shape (n, 3)."""
    corners = shape.vertices[shape.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = 2 ** np.ceil(np.log2(np.maximum(longest / spacing, 1.0))).astype(np.int64)
    results = []
    for part in np.unique(parts):
        i, j = np.meshgrid(np.arange(part + 1), np.arange(part + 1))
        inside = i + j <= part
        weight = np.stack([(part - i - j)[inside], i[inside], j[inside]], axis=1) / part
        results.append((weight @ corners[parts == part]).reshape(-1, 3))
    return np.concatenate(results)


def _closed(distance: Grid, radius: float) -> Grid:
    """Return how deep points lie under the skin of what a ball from outside cannot reach."""
    from scipy.ndimage import distance_transform_edt, label

    # Half a step more than nothing: else the ball slips between the points themselves.
    radius = max(radius, 0.75 * distance.step)
    free: Mask = distance.values > radius
    regions, _ = label(free)
    outside = regions == regions[0, 0, 0]
    depth, nearest = distance_transform_edt(~outside, return_indices=True)
    beyond = distance.values[tuple(nearest)] - radius
    # The ball's centre may come nearer than the nearest point outside, by what that has to spare.
    inside = depth * distance.step - np.minimum(beyond, distance.step) - radius
    values = np.where(outside, -distance.values, inside)
    return Grid(origin=distance.origin, step=distance.step, values=values)


def _blurred(grid: Grid, steps: float) -> Grid:
    from scipy.ndimage import gaussian_filter

    values = gaussian_filter(grid.values, steps, mode="nearest")
    return Grid(origin=grid.origin, step=grid.step, values=values)


def _any(count: int) -> Integers:
    """Return faces that use every corner, for a hull to start from."""
    return np.arange(count + -count % 3, dtype=np.int64).clip(max=count - 1).reshape(-1, 3)


def _skin(grid: Grid, edge: float) -> Any:
    from manifold3d import Manifold

    steps = np.array(grid.values.shape) - 1
    table = grid.values.ravel().tolist()
    (ox, oy, oz), step = grid.origin.tolist(), grid.step
    (lx, ly, lz), row, plane = (
        steps.tolist(),
        grid.values.shape[2],
        grid.values.shape[1] * grid.values.shape[2],
    )

    def depth(x: float, y: float, z: float) -> float:
        # Linear between the eight points around; plain numbers, as one place comes at a time.
        x = min(max((x - ox) / step, 0.0), lx - 1e-9)
        y = min(max((y - oy) / step, 0.0), ly - 1e-9)
        z = min(max((z - oz) / step, 0.0), lz - 1e-9)
        i, j, k = int(x), int(y), int(z)
        x, y, z = x - i, y - j, z - k
        at = i * plane + j * row + k
        total = 0.0
        for along, wx in ((at, 1.0 - x), (at + plane, x)):
            for across, wy in ((along, 1.0 - y), (along + row, y)):
                total += wx * wy * (table[across] * (1.0 - z) + table[across + 1] * z)
        return total

    high = grid.origin + step * steps
    box = (ox, oy, oz, *(float(value) for value in high))
    # A little inside, where sheets that stick out of the skin are left behind.
    skin = Manifold.level_set(depth, box, edge, SHY * step)
    return None if skin.is_empty() else skin


def _volume(grid: Grid) -> float:
    """Return what a field of depths encloses, m3; of cells that it cuts, the part inside."""
    part = np.clip(grid.values / grid.step + 0.5, 0.0, 1.0)
    return float(part.sum()) * grid.step**3


def _of_volume(mesh: Mesh, volume: float) -> Mesh:
    """Return a mesh grown about its centre to a volume: its triangles cut every edge short."""
    grown = (volume / mesh.volume) ** (1.0 / 3.0)
    return Mesh(vertices=mesh.com + grown * (mesh.vertices - mesh.com), faces=mesh.faces)


def _is_sheet(skin: Any, step: float) -> bool:
    """Whether a skin is on average thinner than the grid that it was found on can tell."""
    # A plate of thickness t has the volume t A / 2, where A counts both sides.
    return bool(2.0 * skin.volume() < step * skin.surface_area())


def _without_crumbs(skin: Any) -> Mesh:
    from manifold3d import Manifold

    pieces = skin.decompose()
    whole = sum(piece.volume() for piece in pieces)
    kept = [piece for piece in pieces if piece.volume() > CRUMB * whole]
    return from_manifold(Manifold.compose(kept))
