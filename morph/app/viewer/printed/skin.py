"""Parts light enough for a browser, and their corners coloured by what is asked."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.web_shapes import web_shapes
from morph.arrays import Array, Integers
from morph.print.errors import PrintError
from morph.print.job import Job
from morph.print.mesh import Mesh
from morph.print.overhang import overhanging
from morph.print.part import Part
from morph.print.printer import Profile

MM = 1e-3
"""One millimetre, m."""

PLAIN = np.array([178.0, 187.0, 197.0])
"""Where there is nothing to tell."""

WARM, HOT = np.array([244.0, 200.0, 92.0]), np.array([213.0, 30.0, 20.0])
"""Where it comes near a limit, and where it is beyond."""

BED = np.array([64.0, 132.0, 190.0])
"""What lies on the bed."""

LEANS = np.radians(15.0)
"""What leans out less is upright, as far as colours tell."""

THICK = 4.0
"""Walls of so many times the thinnest one are thick, as far as colours tell."""

SKIN_MM = 1e-3
"""How far within the surface a ray starts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Skin:
    """What is drawn of a part, in its own frame."""

    part: Part
    """The part."""
    vertices: Array
    """Corners, mm, shape (vertices, 3)."""
    faces: Integers
    """Triangles, shape (faces, 3)."""

    @property
    def normals(self) -> Array:
        """Mean of the normals of each corner's faces, by their area, shape (vertices, 3)."""
        corner = self.vertices[self.faces]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        total = np.zeros_like(self.vertices)
        np.add.at(total, self.faces.ravel(), np.repeat(normal, 3, axis=0))
        return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1), 1e-12)[:, None])


def skins(parts: Iterable[Part]) -> dict[str, Skin]:
    """Return what is drawn of each part that has a shape, by its name."""
    shaped = [(part, part.mesh) for part in parts if part.mesh is not None]
    drawn = web_shapes(
        PictureShape(
            body=at,
            vertices=mesh.vertices,
            faces=mesh.faces,
            colour=(0, 0, 0),
            opacity=1.0,
            flat=False,
        )
        for at, (_, mesh) in enumerate(shaped)
    )
    return {
        shaped[it.body][0].name: Skin(part=shaped[it.body][0], vertices=it.vertices, faces=it.faces)
        for it in drawn
    }


def overhang(skin: Skin, job: Job) -> Array | None:
    """Return colours that tell how far faces lean out as they are printed, shape (vertices, 3).

    None of a part that is not printed.
    """
    lies = job.orientations.get(skin.part.name)
    if lies is None:
        return None
    normals, height = skin.normals @ lies.turn.T, (skin.vertices @ lies.turn.T)[:, 2]
    leans = np.arcsin(np.clip(-normals[:, 2], -1.0, 1.0))
    limit = np.radians(job.profile.overhang_deg)
    warm = np.clip((leans - LEANS) / max(limit - LEANS, 1e-6), 0.0, 1.0)
    colours = mixed(PLAIN, WARM, warm)
    colours[overhanging(normals, job.profile)] = HOT
    colours[(height < height.min() + job.profile.layer_mm) & (normals[:, 2] < -0.9)] = BED
    return colours


def wall(skin: Skin, job: Job) -> Array | None:
    """Return colours that tell how thick it is beneath each corner, shape (vertices, 3).

    None of a part that is not printed, or is no solid.
    """
    mesh = skin.part.mesh
    if mesh is None or skin.part.name not in job.orientations:
        return None
    try:
        depth = thickness(mesh, skin)
    except PrintError:
        return None
    thin = job.profile.thinnest_mm
    thick = np.clip((depth / thin - 1.0) / (THICK - 1.0), 0.0, 1.0)
    colours = mixed(WARM, PLAIN, thick)
    colours[depth < thin] = HOT
    return colours


def thickness(mesh: Mesh, skin: Skin) -> Array:
    """Return how far a ray goes inward from each corner before it leaves the solid, mm.

    Raises:
        SolidError: The mesh encloses no solid.
    """
    solid, normals = mesh.manifold, skin.normals
    reach = 1.1 * float(np.linalg.norm(mesh.extent)) + 1.0
    # From the middle of the faces: at a corner or an edge there is no telling which side a ray is.
    middle = skin.vertices[skin.faces].mean(axis=1)
    inward = -normals[skin.faces].mean(axis=1)
    inward /= np.maximum(np.linalg.norm(inward, axis=1), 1e-12)[:, None]
    begin, end = middle + SKIN_MM * inward, middle + reach * inward
    depth = np.full(len(middle), np.nan)
    for at in range(len(middle)):
        hits = solid.ray_cast(begin[at], end[at])
        if hits:
            depth[at] = hits[0].distance * (reach - SKIN_MM) + SKIN_MM
    # Thinned faces may lie a little outside of the solid, whose near side is met at once.
    depth[depth < 0.05] = np.nan
    return _at_corners(depth, skin)


def _at_corners(values: Array, skin: Skin) -> Array:
    """Return the least of the values of each corner's faces; without any, the greatest of all."""
    result = np.full(len(skin.vertices), np.inf)
    known = np.isfinite(values)
    np.minimum.at(result, skin.faces[known].ravel(), np.repeat(values[known], 3))
    most = float(values[known].max()) if known.any() else 0.0
    return np.where(np.isfinite(result), result, most)


def mixed(first: Array, second: Array, share: Array) -> Array:
    """Return colours between two, by a share from 0 to 1, shape (many, 3)."""
    return np.asarray(first + share[:, None] * (second - first))


Painter = Callable[[Skin, Job], "Array | None"]

PAINTERS: dict[str, Painter] = {"overhang": overhang, "wall thickness": wall}
"""What colours the corners, by what it tells."""


def legend(by: str, profile: Profile) -> tuple[tuple[str, Array], ...]:
    """Return what each colour means."""
    if by == "overhang":
        return (
            ("lies on the bed", BED),
            ("upright or looking up", PLAIN),
            (f"leans out, and prints without support up to {profile.overhang_deg:g}°", WARM),
            ("needs support", HOT),
        )
    thin = profile.thinnest_mm
    return (
        (f"thinner than two lines: under {thin:g} mm", HOT),
        (f"{thin:g} mm and a little more", WARM),
        (f"{THICK * thin:.2g} mm and more", PLAIN),
    )
