"""Cost of a print orientation: time and support material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array, Integers
from morph.print.mesh import Mesh
from morph.print.overhang import overhanging
from morph.print.printer import Profile

DRAWN = 3000
"""Of how many faces the first look takes notice."""

SUPPORT_SHARE = 0.16
"""Part of the supported volume that is filled with plastic: thin lines 2.5 mm apart."""

FACE_MM = 0.4
"""Thickness of the dense layers between support and part, in mm of plastic.

Both were fitted to what PrusaSlicer 2.5.0 gives six parts of Open Duck Mini in 36 orientations;
half of them are within 38 %, since it bridges some of what hangs over.
"""

WASTE = 1.0
"""What support costs beside its time, in its time: it is thrown away, and leaves scars."""

OUTLINE_S = 0.048
"""What each millimetre of outline takes with all its lines, s."""

FILL_S = 0.27
"""What each mm3 of other plastic takes, s."""

LAYER_S = 8.8
"""What each layer takes beside, s: it begins, it ends, corners slow the head down.

These three were fitted to PrusaSlicer 2.5.0's times of six parts of Open Duck Mini in six
orientations each, two lines around at 45 and 25 mm/s, the rest at 80; the median error is 4 %.
"""

COOL_S = 15.0
"""Least time of a layer, s: less and it is still soft under the next, so the head slows down."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ways:
    """Ways in which a part can lie, and what each costs as far as faces alone tell."""

    downs: Array
    """What points down, in the part's frame, shape (n, 3)."""
    height: Array
    """How high it stands, mm, shape (n,)."""
    outline: Array
    """Length of the outlines of all layers together, mm, shape (n,)."""
    support: Array
    """Plastic of the support if all of it reached the bed, mm3, shape (n,)."""


def ways(mesh: Mesh, downs: Array, profile: Profile) -> Ways:
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
    # An outline's length times the layer is the area that is seen from the side.
    side = (area * np.sqrt(np.maximum(1.0 - down**2, 0.0))).sum(axis=0)
    return Ways(
        downs=downs,
        height=along.max(axis=0) - lowest,
        outline=side / profile.layer_mm,
        support=SUPPORT_SHARE * (held * rise).sum(axis=0) + FACE_MM * held.sum(axis=0),
    )


def plastic(mesh: Mesh, profile: Profile) -> float:
    """Return about how much plastic a part takes however it lies, mm3: walls, and what is filled.

    Within 6 % of PrusaSlicer's for the parts that the times were fitted to.
    """
    a, b, c = mesh.corners.transpose(1, 0, 2)
    skin = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    wall = min(profile.walls * profile.line_mm * skin, mesh.volume)
    return wall + profile.infill * (mesh.volume - wall)


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


def seconds(lying: Ways, part: float, profile: Profile) -> Array:
    """Return about how long a print takes without support, s, shape (n,).

    Args:
        lying: Ways to lie.
        part: Plastic of the part, mm3, as `plastic` says.
        profile: The lines.
    """
    layers = lying.height / profile.layer_mm
    walls = profile.walls * profile.line_mm * profile.layer_mm * lying.outline
    filled = np.maximum(part - walls, 0.0)
    laid = OUTLINE_S * lying.outline + FILL_S * filled + LAYER_S * layers
    slow: Array = np.maximum(laid, COOL_S * layers)
    return slow


def wasted(support: Array) -> Array:
    """Return what support costs, s: its time, and that it is thrown away.

    Args:
        support: Its plastic, mm3.
    """
    return (1.0 + WASTE) * FILL_S * support


def support_plastic(under_mm3: float, under_mm2: float) -> float:
    """Return the plastic of support, mm3, by the volume and the area of what it holds up."""
    return SUPPORT_SHARE * under_mm3 + FACE_MM * under_mm2
