"""How a part lies on the bed: by search, so that it stands and needs little support."""

from __future__ import annotations

import numpy as np

from morph.print.arrays import Array
from morph.print.bed import about_up, hull, room
from morph.print.directions import resting, spread, turned_down
from morph.print.errors import PlateError
from morph.print.job import Orientation
from morph.print.mesh import Mesh
from morph.print.orientation_cost import plastic, seconds, support_plastic, wasted, ways
from morph.print.overhang import Standing, standing
from morph.print.printer import Profile

FINALISTS = 24
"""How many of the ways that look best at first are looked at column by column."""

SLENDER = 12.0
"""How often the side of the square that it stands on goes into the height before it may fall."""

FALL_S = 1200.0
"""What a height of another `SLENDER` costs, s, since a print that falls over is lost."""


def orient(mesh: Mesh, profile: Profile) -> Orientation:
    """Return how a part should lie.

    As it was given is tried, then the largest faces of its convex hull, and directions spread over
    the sphere. All are judged by faces alone, the best of them column by column, by the time that
    outlines, layers and support cost.

    Raises:
        PlateError: It fits the bed in none of them.
    """
    # Given first: of equals the first stays, and a part that lies well is left as it was drawn.
    given = np.array([[0.0, 0.0, -1.0]])
    lying = ways(mesh, np.concatenate([given, resting(mesh), spread()]), profile)
    dry = seconds(lying, plastic(mesh, profile), profile)
    outline = hull(mesh)
    best: tuple[float, Array, Standing] | None = None
    tried = 0
    for at in np.argsort(dry + wasted(lying.support), kind="stable"):
        turn = turned_down(lying.downs[at])
        upright = about_up(outline @ turn.T, profile)
        if upright is None:
            continue
        result = standing((mesh.vertices @ turn.T)[mesh.faces], profile)
        support = support_plastic(result.support_mm3, result.supported_mm2)
        falls = _falls(result, float(lying.height[at]), profile)
        cost = float(dry[at] + wasted(np.array(support)) + falls)
        if best is None or cost < best[0] - 1e-6:
            best = cost, upright @ turn, result
        tried += 1
        if tried == FINALISTS:
            break
    if best is None:
        raise _too_large(mesh, profile)
    _, turn, result = best
    return Orientation(
        turn=turn,
        support_mm3=result.support_mm3,
        first_support_mm3=standing(mesh.corners, profile).support_mm3,
        height_mm=float(np.ptp(outline @ turn[2])),
    )


def fits(mesh: Mesh, profile: Profile) -> bool:
    """Return whether a part fits the bed lying on some face of its convex hull."""
    outline = hull(mesh)
    return any(
        about_up(outline @ turned_down(down).T, profile) is not None for down in resting(mesh)
    )


def _falls(result: Standing, height: float, profile: Profile) -> float:
    """Return what it costs that a print may fall over, s."""
    base = np.sqrt(max(result.contact_mm2, profile.line_mm**2))
    return float(FALL_S * max(0.0, height / (SLENDER * base) - 1.0))


def _too_large(mesh: Mesh, profile: Profile) -> PlateError:
    size = " x ".join(f"{length:.0f}" for length in mesh.extent)
    bed = " x ".join(f"{length:.0f}" for length in room(profile))
    return PlateError(
        f"a part of {size} mm fits the {bed} mm of the {profile.printer.title} in no orientation",
        where="morph.print.orient",
        fix="split it (print.split), or name a larger printer",
    )
