"""A shaded drawing of meshes as SVG, made without a screen or a graphics card."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby

import numpy as np

from morph.print.arrays import Array, Integers, Mask
from morph.print.callout import Callout, callouts
from morph.print.decimate import lighter
from morph.print.mesh import Mesh

Colour = tuple[int, int, int]

TOWARDS = np.array([0.55, -1.0, 0.62])
"""From what is drawn to who looks: from the front, the right and above."""

LIGHT = np.array([-0.35, -0.55, 0.75])
"""From what is drawn to the light, over the left shoulder of who looks."""

FACES = 5000
"""Triangles of a drawing: it has about 300 kB, and what is large is still itself."""

LEAST = 60
"""Triangles that every mesh keeps."""

SHADES = 24
"""Steps from dark to light."""

CREASE = 0.8
"""Cosine between faces whose edge is drawn."""

WIDTH, MARGIN = 1000, 90
"""Of the drawing and of the room at either side for numbers, in its own units."""

FLATTEST, TALLEST = 0.45, 1.25
"""A drawing's height by its width."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedMesh:
    """A mesh where it is to be drawn."""

    mesh: Mesh
    """In the world, mm, z up."""
    colour: Colour
    """Of its faces in full light."""
    label: str = ""
    """What a line points at it with; empty for nothing."""


def picture(
    drawn: Sequence[PlacedMesh],
    *,
    title: str,
    towards: Array = TOWARDS,
    faces: int = FACES,
    margin: float = MARGIN,
) -> str:
    """Return a drawing as an SVG element.

    Faces are drawn from the farthest to the nearest, the painter's way, with Lambert's shading
    and a line wherever two of them meet at an edge.

    Args:
        drawn: What is drawn; at least one mesh.
        title: What is told to who cannot see it.
        towards: From what is drawn to who looks, not upright, shape (3,).
        faces: About how many triangles it has.
        margin: Room at either side, of a width of `WIDTH`.
    """
    view = _view(towards)
    most = _shares(drawn, faces)
    light = [lighter(each.mesh, few) for each, few in zip(drawn, most, strict=True)]
    flat = [mesh.vertices @ view.T for mesh in light]
    low = np.min([points[:, :2].min(axis=0) for points in flat], axis=0)
    high = np.max([points[:, :2].max(axis=0) for points in flat], axis=0)
    wide, tall = np.maximum(high - low, 1e-6)
    inner = WIDTH - 2.0 * margin
    scale = min(inner / wide, (TALLEST * WIDTH - 40.0) / tall)
    height = max(scale * tall + 40.0, FLATTEST * WIDTH)
    middle = 0.5 * (low + high)

    def put(points: Array) -> Array:
        xy = (points[:, :2] - middle) * scale * (1.0, -1.0) + (0.5 * WIDTH, 0.5 * height)
        return np.column_stack((xy, points[:, 2]))

    placed = [put(points) for points in flat]
    painted = _faces(drawn, light, placed, view)
    labels = callouts(
        [
            (each.label, _amid(mesh, xy, view))
            for each, mesh, xy in zip(drawn, light, placed, strict=True)
            if each.label
        ],
        width=WIDTH,
        height=height,
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0f}" role="img" '
        f'font-family="system-ui,sans-serif"><title>{escape(title)}</title>'
        f'<g stroke-width="0.7" stroke-linejoin="round">{painted}</g>{_labels(labels)}</svg>'
    )


def _view(towards: Array) -> Array:
    """Return the rotation into the picture: right, up, and towards who looks, shape (3, 3)."""
    forward = towards / np.linalg.norm(towards)
    right = np.cross((0.0, 0.0, 1.0), forward)
    right /= np.linalg.norm(right)
    return np.stack((right, np.cross(forward, right), forward))


def _shares(drawn: Sequence[PlacedMesh], faces: int) -> list[int]:
    """Return how many triangles each mesh may have: the larger its surface, the more."""
    area = np.array([max(float(each.mesh.trimesh.area), 1e-9) for each in drawn])
    # Small parts have as many edges as large ones, and show fewer: a power lies between both.
    weight = area**0.7
    return [max(LEAST, round(faces * each)) for each in (weight / weight.sum()).tolist()]


def _amid(mesh: Mesh, xy: Array, view: Array) -> Array:
    """Return a place in the picture near the middle of a mesh and on it, shape (2,)."""
    faces = mesh.faces[np.asarray(mesh.trimesh.face_normals) @ view[2] > 1e-3]
    middle = 0.5 * (xy.min(axis=0) + xy.max(axis=0))[:2]
    if not len(faces):
        return np.asarray(middle)
    places = xy[faces].mean(axis=1)[:, :2]
    return np.asarray(places[np.linalg.norm(places - middle, axis=1).argmin()])


def _faces(
    drawn: Sequence[PlacedMesh], light: Sequence[Mesh], placed: Sequence[Array], view: Array
) -> str:
    """Return the paths of all faces that look this way, the farthest first."""
    shine = LIGHT / np.linalg.norm(LIGHT)
    depth, styles, edged, corners = [], [], [], []
    for number, (mesh, xy) in enumerate(zip(light, placed, strict=True)):
        normal = np.asarray(mesh.trimesh.face_normals)
        seen = normal @ view[2] > 1e-3
        bright = 0.45 + 0.55 * np.clip(normal[seen] @ shine, 0.0, 1.0)
        step = np.rint(SHADES * bright).astype(np.int64)
        styles.append(number * (SHADES + 1) + step)
        corners.append(xy[mesh.faces[seen]])
        depth.append(corners[-1][:, :, 2].mean(axis=1))
        edged.append(_edged(mesh, normal)[seen])
    order = np.argsort(np.concatenate(depth), kind="stable")
    style, corner = np.concatenate(styles)[order], np.concatenate(corners)[order, :, :2]
    sharp = np.concatenate(edged)[order]
    rounded = np.round(corner, 1)
    # What has no extent in the picture is not drawn.
    wide = np.ptp(rounded, axis=1).max(axis=1) > 0.15
    parts = []
    which = np.flatnonzero(wide)
    for key, group in groupby(which.tolist(), key=lambda at: int(style[at])):
        members = list(group)
        fill = _css(drawn[key // (SHADES + 1)].colour, key % (SHADES + 1) / SHADES)
        path = "".join(_path(rounded[at]) for at in members)
        parts.append(f'<path fill="{fill}" stroke="{fill}" d="{path}"/>')
        lines = "".join(_lines(rounded[at], sharp[at]) for at in members)
        if lines:
            parts.append(f'<path stroke="#24303c" fill="none" d="{lines}"/>')
    return "".join(parts)


def _edged(mesh: Mesh, normal: Array) -> Mask:
    """Return which edges of each face are to be drawn, shape (faces, 3): edge i begins at i."""
    start = mesh.faces.ravel()
    end = np.roll(mesh.faces, -1, axis=1).ravel()
    ends = np.sort(np.column_stack((start, end)), axis=1)
    key: Integers = ends[:, 0] * (len(mesh.vertices) + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    first, second = order[:-1][same], order[1:][same]
    alike = (normal[first // 3] * normal[second // 3]).sum(axis=1) > CREASE
    smooth = np.zeros(len(key), dtype=np.bool_)
    smooth[first[alike]] = smooth[second[alike]] = True
    return np.asarray(~smooth.reshape(-1, 3))


def _number(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


def _step(now: Array, before: Array) -> str:
    x, y = (_number(float(each)) for each in now - before)
    return f"{x}{'' if y.startswith('-') else ' '}{y}"


def _path(corner: Array) -> str:
    a, b, c = corner
    return f"M{_number(a[0])} {_number(a[1])}l{_step(b, a)} {_step(c, b)}z"


def _lines(corner: Array, sharp: Mask) -> str:
    text = ""
    for at in np.flatnonzero(sharp).tolist():
        a, b = corner[at], corner[(at + 1) % 3]
        text += f"M{_number(a[0])} {_number(a[1])}l{_step(b, a)}"
    return text


def _css(colour: Colour, bright: float) -> str:
    red, green, blue = (min(255, round(bright * each)) for each in colour)
    return f"#{red:02x}{green:02x}{blue:02x}"


def _labels(labels: Sequence[Callout]) -> str:
    results = []
    for each in labels:
        x, y = each.at
        to_x, to_y = each.points_to
        half = 5.0 + 4.6 * len(each.text)
        left = x - half
        results.append(
            f'<path d="M{x:.1f} {y:.1f}L{to_x:.1f} {to_y:.1f}" stroke="#24303c" '
            f'stroke-width="1" fill="none"/><circle cx="{to_x:.1f}" cy="{to_y:.1f}" r="2.6" '
            f'fill="#24303c"/><rect x="{left:.1f}" y="{y - 11:.1f}" width="{2 * half:.1f}" '
            f'height="22" rx="11" fill="#fff" stroke="#24303c"/><text x="{x:.1f}" y="{y + 5:.1f}" '
            f'text-anchor="middle" font-size="14">{escape(each.text)}</text>'
        )
    return "".join(results)
