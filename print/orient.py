"""How a part lies on the bed: by search, so that it stands and needs little support."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from print.arrays import Array, Integers
from print.bed import about_up, hull, room
from print.directions import resting, spread, turned_down
from print.errors import PlateError
from print.job import Orientation
from print.mesh import Mesh
from print.overhang import Standing, overhanging, standing
from print.printer import Profile

FINALISTS = 24
"""How many of the ways that look best at first are looked at column by column."""

DRAWN = 3000
"""Of how many faces the first look takes notice."""

SUPPORT_SHARE = 0.2
"""Part of the supported volume that is filled with plastic: thin lines 2 to 2.5 mm apart."""

FACE_MM = 0.8
"""Thickness of the dense layers between support and part, in mm of plastic."""

WASTE = 1.0
"""What support costs once more for being thrown away, and for the scars that it leaves."""

FLOW = 5.0
"""Plastic laid down in a second, mm3, moves counted in."""

LAYER_S = 2.0
"""What each layer costs beside its plastic, s: it begins, it ends, the head is lifted."""

COOL_S = 15.0
"""Least time of a layer, s: less and it is still soft under the next, so the head slows down."""

SLENDER = 12.0
"""How often the side of the square that it stands on goes into the height before it may fall."""

FALL_S = 1200.0
"""What a height of another `SLENDER` costs, s, since a print that falls over is lost."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ways:
    """Ways in which a part can lie, and what each costs as far as faces alone tell."""

    downs: Array
    """What points down, in the part's frame, shape (n, 3)."""
    height: Array
    """How high it stands, mm, shape (n,)."""
    plastic: Array
    """Plastic of the part itself, mm3, shape (n,): level faces take dense layers."""
    support: Array
    """Plastic of the support if all of it reached the bed, mm3, shape (n,)."""


def orient(mesh: Mesh, profile: Profile) -> Orientation:
    """Return how a part should lie.

    Every face of the convex hull that it could stand on is tried, and directions spread over the
    sphere. All are judged by faces alone, the best of them column by column, by the time that
    support, layers and the dense layers of level faces cost.

    Raises:
        PlateError: It fits the bed in none of them.
    """
    # Given first: of equals the first stays, and a part that lies well is left as it was drawn.
    given = np.array([[0.0, 0.0, -1.0]])
    ways = _ways(mesh, np.concatenate([given, resting(mesh), spread()]), profile)
    rough = _seconds(ways.plastic, ways.support, ways.height, profile)
    outline = hull(mesh)
    best: tuple[float, Array, Standing] | None = None
    tried = 0
    for at in np.argsort(rough, kind="stable"):
        lying = turned_down(ways.downs[at])
        upright = about_up(outline @ lying.T, profile)
        if upright is None:
            continue
        found = standing((mesh.vertices @ lying.T)[mesh.faces], profile)
        cost = _cost(found, float(ways.plastic[at]), float(ways.height[at]), profile)
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
        first_support_mm3=standing(mesh.corners, profile).support_mm3,
        height_mm=float(np.ptp(outline @ turn[2])),
    )


def fits(mesh: Mesh, profile: Profile) -> bool:
    """Return whether a part fits the bed lying on some face of its convex hull."""
    outline = hull(mesh)
    return any(
        about_up(outline @ turned_down(down).T, profile) is not None for down in resting(mesh)
    )


def _ways(mesh: Mesh, downs: Array, profile: Profile) -> _Ways:
    """Return what directions cost by the part's faces."""
    corners = mesh.corners
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(cross, axis=1)
    seen, area = _seen(0.5 * twice)
    # How far each face looks down, shape (faces, directions): 1 down, -1 up.
    down = (cross[seen] / twice[seen, None]) @ downs.T
    along = mesh.vertices @ -downs.T
    lowest = along.min(axis=0)
    rise = corners[seen].mean(axis=1) @ -downs.T - lowest
    leans = overhanging(np.stack([0.0 * down, 0.0 * down, -down], axis=-1), profile)
    held = np.where(leans & (rise > profile.layer_mm), area * np.abs(down), 0.0)
    wall = profile.walls * profile.line_mm
    # A wall is as thick upwards as its face is steep; dense layers add what that lacks.
    steep = np.sqrt(np.maximum(1.0 - down**2, 0.0))
    dense = profile.layer_mm * np.where(down < 0, *profile.solid_layers)
    level = area * np.maximum(dense * np.abs(down) - wall * steep, 0.0)
    within = max(mesh.volume - wall * float(area.sum()), 0.0)
    shell = min(wall * float(area.sum()), mesh.volume) + (1.0 - profile.infill) * np.minimum(
        level.sum(axis=0), within
    )
    return _Ways(
        downs=downs,
        height=along.max(axis=0) - lowest,
        plastic=shell + profile.infill * within,
        support=SUPPORT_SHARE * (held * rise).sum(axis=0) + FACE_MM * held.sum(axis=0),
    )


def _seen(areas: Array) -> tuple[Integers, Array]:
    """Return which faces are looked at, and the area that each stands for, mm2, shape (n, 1).

    Of many faces some are drawn, each as likely as it is large, by equal steps of their area.
    """
    if len(areas) <= DRAWN:
        seen = np.flatnonzero(areas > 0.0)
        return seen, areas[seen, None]
    total = np.cumsum(areas)
    steps = (np.arange(DRAWN) + 0.5) * (total[-1] / DRAWN)
    return np.searchsorted(total, steps), np.full((DRAWN, 1), total[-1] / DRAWN)


def _seconds(plastic: Array, support: Array, height: Array, profile: Profile) -> Array:
    """Return about how long a print takes, s, and once more for what is thrown away."""
    layers = height / profile.layer_mm
    laid = (plastic + support) / FLOW + LAYER_S * layers
    seconds: Array = np.maximum(laid, COOL_S * layers) + WASTE * support / FLOW
    return seconds


def _cost(found: Standing, plastic: float, height: float, profile: Profile) -> float:
    """Return what a way to lie costs that was looked at column by column, s."""
    support = SUPPORT_SHARE * found.support_mm3 + FACE_MM * found.supported_mm2
    took = _seconds(np.array(plastic), np.array(support), np.array(height), profile)
    base = np.sqrt(max(found.contact_mm2, profile.line_mm**2))
    fall = FALL_S * max(0.0, height / (SLENDER * base) - 1.0)
    return float(took + fall)


def _too_large(mesh: Mesh, profile: Profile) -> PlateError:
    size = " x ".join(f"{length:.0f}" for length in mesh.extent)
    bed = " x ".join(f"{length:.0f}" for length in room(profile))
    return PlateError(
        f"a part of {size} mm fits the {bed} mm of the {profile.printer.title} in no orientation",
        where="print.orient",
        fix="split it (print.split), or name a larger printer",
    )
