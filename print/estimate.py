"""How a part will come off the printer, without a slicer: layer by layer, from its sections.

Each section is divided as a slicer divides it: walls along its outline, solid where a layer
above or below does not cover it, and infill elsewhere. How full the three are was fitted to
PrusaSlicer on other parts than those on which the error is stated (`experiments.print_mass`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array
from morph.print.bed_pose import back, laid, mesh_of
from morph.print.job import Orientation
from morph.print.part import Part
from morph.print.printer import Profile
from morph.print.sections import Section, inset, moments, sections
from morph.print.sliced import Sliced
from morph.print.solid_layers import shells
from morph.print.support import support_mm3
from morph.print.weight import MM, Weight

ANCHORS = ((0.0, 0.1, 0.4, 0.8, 1.0), (0.0, 0.115, 0.115, 0.035, 0.03))
"""Lines of infill end in an anchor along the wall: how wide a rim that fills, mm, by infill."""
SOLID_RIM_MM = 0.03
"""Lines of solid layers overlap the wall: so wide a rim is filled once more."""

WALL_SPEED, SOLID_SPEED, INFILL_SPEED, SUPPORT_SPEED = 23.0, 42.0, 99.0, 39.0
"""Mean speeds along lines, mm/s, with all that goes on between them; fitted to PrusaSlicer."""
LAYER_S = 2.0
"""What each layer takes besides its lines, s; fitted with them."""
COOLING_S, LEAST_SPEED = 15.0, 9.0
"""Layers that take less time than this, s, are printed more slowly, down to so many mm/s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Layers:
    """How full each layer of a part is, each an array of moments of shape (layers, 6)."""

    walls: Array
    """Lines along the outline."""
    solid: Array
    """Solid surfaces on top and at the bottom."""
    infill: Array
    """What is in between."""


def estimated(part: Part, orientation: Orientation, profile: Profile) -> Sliced:
    """Return about how one copy of a part comes off the printer.

    Raises:
        SolidError: The part's mesh encloses no solid.
        SlicerError: The part has no mesh.
    """
    mesh = mesh_of(part)
    pose = laid(mesh, orientation.turn, profile)
    cuts = sections(mesh.moved(pose), profile.layer_mm)
    layers = divided(cuts, profile)
    density = profile.material.density * MM**3
    support = support_mm3(cuts, profile)
    grams = {
        "Perimeter": layers.walls,
        "Solid infill": layers.solid,
        "Internal infill": layers.infill,
    }
    by_feature = {
        name: float(each[:, 0].sum()) * profile.layer_mm * density for name, each in grams.items()
    }
    by_feature["Support material"] = support * density
    return Sliced(
        source="estimate",
        weight=_weight(sum(grams.values(), np.zeros(6)), profile).moved(back(pose)),
        support_kg=support * density,
        seconds=_seconds(layers, support, profile),
        by_feature={name: mass for name, mass in by_feature.items() if mass > 0},
    )


def spacing(profile: Profile) -> float:
    """Return the distance between neighbouring lines, mm.

    A line is a rectangle with round ends, w wide and h high, and lines overlap as far as
    fills the gaps: w - h (1 - pi / 4). Source: Slic3r's manual, Flow math.
    """
    return profile.line_mm - profile.layer_mm * (1.0 - np.pi / 4.0)


def divided(cuts: list[Section], profile: Profile) -> Layers:
    """Return how full each layer is.

    Args:
        cuts: Its section at each layer, the lowest first.
        profile: Walls, solid layers and infill.
    """
    step = spacing(profile)
    edge = (profile.line_mm - step) / 2.0
    inner = [inset(cut, edge + profile.walls * step) for cut in cuts]
    solid = shells(cuts, inner, profile)
    sparse = [inside - shell for inside, shell in zip(inner, solid, strict=True)]
    inside = _moments(inner)
    thin = _moments(sparse)
    return Layers(
        walls=_moments([inset(cut, edge) for cut in cuts]) - inside,
        solid=inside - thin + _rims(solid, SOLID_RIM_MM),
        infill=profile.infill * thin + _rims(sparse, float(np.interp(profile.infill, *ANCHORS))),
    )


def _moments(row: list[Section]) -> Array:
    return np.array([moments(each) for each in row])


def _rims(row: list[Section], width_mm: float) -> Array:
    """Return the moments of what is nearer to the outline of each section than a width."""
    return _moments(row) - _moments([inset(each, width_mm) for each in row])


def _weight(sums: Array, profile: Profile) -> Weight:
    """Return layers of given moments, shape (layers, 6), mm, as one body."""
    height = profile.layer_mm
    middle = (np.arange(len(sums)) + 0.5) * height
    area, x, y, xx, xy, yy = sums.T * height
    volume = float(area.sum())
    if volume <= 0.0:
        return Weight(mass=0.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    com = np.array([x.sum(), y.sum(), area @ middle]) / volume
    second = np.array(
        [
            [xx.sum(), xy.sum(), x @ middle],
            [xy.sum(), yy.sum(), y @ middle],
            [x @ middle, y @ middle, area @ (middle**2 + height**2 / 12.0)],
        ]
    )
    second -= volume * np.outer(com, com)
    density = profile.material.density
    return Weight(
        mass=density * volume * MM**3,
        com=com * MM,
        inertia=density * (np.trace(second) * np.eye(3) - second) * MM**5,
    )


def _seconds(layers: Layers, support: float, profile: Profile) -> float:
    """Return about how long it takes: lengths of lines by speed, slower on small layers."""
    cross = spacing(profile)
    walls, solid, infill = (
        each[:, 0] / cross for each in (layers.walls, layers.solid, layers.infill)
    )
    drawn = walls / WALL_SPEED + solid / SOLID_SPEED + infill / INFILL_SPEED + LAYER_S
    slowest = (walls + solid + infill) / LEAST_SPEED
    drawn = np.maximum(drawn, np.minimum(slowest, COOLING_S))
    held = support / (cross * profile.layer_mm * SUPPORT_SPEED)
    return float(drawn.sum() + held)
