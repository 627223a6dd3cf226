"""How a part lies on the bed: by search, so that it stands and needs little support."""

from __future__ import annotations

import numpy as np

from print.arrays import Array
from print.bed import about_up, hull, room
from print.directions import resting, spread, turned_down
from print.errors import PlateError
from print.job import Orientation
from print.mesh import Mesh
from print.overhang import Standing, overhanging, standing
from print.printer import Profile

FINALISTS = 24
"""How many of the ways that look best at first are looked at column by column."""

SUPPORT_SHARE = 0.2
"""Part of the supported volume that is filled with plastic: thin lines 2 to 2.5 mm apart."""

FACE_MM = 0.8
"""Thickness of the dense layers between support and part, in mm of plastic, once more for scars."""

FLOW = 5.0
"""Plastic laid down in a second, mm3, moves counted in."""

LAYER_S = 1.5
"""What each layer costs beside its plastic, s: it begins, it ends, the head is lifted."""

SLENDER = 12.0
"""How often the side of the square that it stands on goes into the height before it may fall."""

FALL_S = 1200.0
"""What a height of another `SLENDER` costs, s, since a print that falls over is lost."""


def orient(mesh: Mesh, profile: Profile) -> Orientation:
    """Return how a part should lie.

    Every face of the convex hull that it could stand on is tried, and directions spread over the
    sphere. All are judged by faces alone, the best of them column by column, by the time that
    support, layers and the dense layers of level faces cost.

    Raises:
        PlateError: It fits the bed in none of them.
    """
    corners = mesh.corners
    # Given first: of equals the first stays, and a part that lies well is left as it was drawn.
    given = np.array([[0.0, 0.0, -1.0]])
    downs = np.concatenate([given, resting(mesh), spread()])
    rough = _rough(mesh, downs, profile)
    outline = hull(mesh)
    best: tuple[float, Array, Standing] | None = None
    tried = 0
    for at in np.argsort(rough, kind="stable"):
        lying = turned_down(downs[at])
        upright = about_up(outline @ lying.T, profile)
        if upright is None:
            continue
        found = standing(corners @ lying.T, profile)
        cost = _cost(found, mesh, downs[at], profile)
        if best is None or cost < best[0] - 1e-6:
            best = cost, upright @ lying, found
        tried += 1
        if tried == FINALISTS:
            break
    if best is None:
        raise _too_large(mesh, profile)
    _, turn, found = best
    return Orientation(
        turn=turn,
        support_mm3=found.support_mm3,
        first_support_mm3=standing(corners, profile).support_mm3,
        height_mm=float(np.ptp(outline @ turn[2])),
    )


def fits(mesh: Mesh, profile: Profile) -> bool:
    """Return whether a part fits the bed lying on some face of its convex hull."""
    outline = hull(mesh)
    return any(
        about_up(outline @ turned_down(down).T, profile) is not None for down in resting(mesh)
    )


def _rough(mesh: Mesh, downs: Array, profile: Profile) -> Array:
    """Return what each direction costs if all support reached the bed, s, shape (n,)."""
    corners = mesh.corners
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    normals = cross / np.where(twice > 0, twice, 1.0)[:, None]
    leaning = normals @ downs.T
    middle = corners.mean(axis=1) @ -downs.T
    lowest = (mesh.vertices @ -downs.T).min(axis=0)
    height = (mesh.vertices @ -downs.T).max(axis=0) - lowest
    area = 0.5 * twice[:, None] * np.maximum(leaning, 0.0)
    leans = overhanging(np.stack([leaning * 0, leaning * 0, -leaning], axis=-1), profile)
    rise = middle - lowest
    held = np.where(leans & (rise > profile.layer_mm), area, 0.0)
    support = SUPPORT_SHARE * (held * rise).sum(axis=0) + FACE_MM * held.sum(axis=0)
    cost: Array = support / FLOW + height / profile.layer_mm * LAYER_S
    return cost


def _cost(found: Standing, mesh: Mesh, down: Array, profile: Profile) -> float:
    """Return what lying so costs, s."""
    height = float(np.ptp(mesh.vertices @ down))
    plastic = SUPPORT_SHARE * found.support_mm3 + FACE_MM * found.supported_mm2
    base = np.sqrt(max(found.contact_mm2, profile.line_mm**2))
    fall = FALL_S * max(0.0, height / (SLENDER * base) - 1.0)
    return float(plastic / FLOW + height / profile.layer_mm * LAYER_S + fall)


def _too_large(mesh: Mesh, profile: Profile) -> PlateError:
    size = " x ".join(f"{length:.0f}" for length in mesh.extent)
    bed = " x ".join(f"{length:.0f}" for length in room(profile))
    return PlateError(
        f"a part of {size} mm fits the {bed} mm of the {profile.printer.title} in no orientation",
        where="print.orient",
        fix="split it (print.split), or name a larger printer",
    )
