"""Whether masses and inertias fit the shapes of their links."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from morph.arrays import Array
from morph.body.check.place import at_link
from morph.body.draft import Draft, DraftLink
from morph.body.finding import DescriptionFinding
from morph.body.solids import Solid, away, bounds, corners, parallel, solid, together

LIGHTEST, HEAVIEST = 1.0, 25_000.0
"""Mean densities of what robots are made of, kg/m3: above air's 1.2, below osmium's 22 590."""

OTHERS = 200.0
"""By how much a part may be denser or lighter than the middle one of its robot."""

WORTH = 0.01
"""Part of the robot's mass, or volume, below which a part is not looked at."""

NEGLIGIBLE = 1e-3
"""Part of the robot's mass below which a link's inertia is a token, as of a sensor's frame."""

WIDEST, NARROWEST = 1.1, 0.01
"""An inertia as a multiple of what all mass at the shape's rim has, and of the filled shape's."""

UNALIKE, ALIKE = 0.3, 0.35
"""How far an inertia must be from the shape's, and which part of that with axes exchanged.

Distances of tensors with a trace of 1; two rods across each other are 0.71 apart.
"""

UNEVEN = 0.15
"""How far a shape's inertia must be from a ball's, so that its axes can be told."""


def check_fit(draft: Draft) -> list[DescriptionFinding]:
    """Return the links whose mass or inertia does not belong to a body of their shape."""
    hulls = {link.name: result for link in draft.links if (result := _hull(link)) is not None}
    findings = _densities(draft, hulls)
    least = NEGLIGIBLE * sum(link.mass or 0.0 for link in draft.links)
    for link in draft.links:
        if link.name in hulls and link.inertia_from == "description" and (link.mass or 0) > least:
            findings.extend(_inertia(draft, link, hulls[link.name]))
    return findings


def _hull(link: DraftLink) -> Solid | None:
    """Return the hull of what a link looks like; collision shapes may be anything near it."""
    visual = [shape for shape in link.shapes if shape.role == "visual"]
    shapes = visual or [shape for shape in link.shapes if shape.kind == "mesh"]
    solids = [solid(shape, hull=True) for shape in shapes]
    if any(one is None for one in solids):
        return None
    return together(one for one in solids if one is not None)


def _densities(draft: Draft, hulls: dict[str, Solid]) -> list[DescriptionFinding]:
    density = {
        link.name: (link.mass or 0.0) / hulls[link.name].volume
        for link in draft.links
        if link.name in hulls and (link.mass or 0.0) > 0 and link.inertia_from == "description"
    }
    if not density:
        return []
    middle = float(np.median(list(density.values())))
    mass = sum(link.mass or 0.0 for link in draft.links)
    volume = sum(hull.volume for hull in hulls.values())
    findings = []
    for link in draft.links:
        if link.name not in density:
            continue
        value = density[link.name]
        dense = (link.mass or 0.0) > WORTH * mass
        dense &= value > HEAVIEST or (len(density) > 2 and value > OTHERS * middle)
        light = hulls[link.name].volume > WORTH * volume
        light &= value < LIGHTEST or (len(density) > 2 and value < middle / OTHERS)
        if dense or light:
            findings.append(_density(draft, link, value, hulls[link.name].volume, middle))
    return findings


def _density(
    draft: Draft, link: DraftLink, value: float, volume: float, middle: float
) -> DescriptionFinding:
    return DescriptionFinding(
        code="mass-volume",
        severity="info",
        where=at_link(draft, link),
        what=f"{link.mass:.4g} kg in {volume * 1e3:.3g} litres are {value:.3g} kg/m3, "
        f"where the middle link has {middle:.3g}",
        fix="check the mass (kg, not g) and the size of the shape (m, not mm)",
    )


def _inertia(draft: Draft, link: DraftLink, hull: Solid) -> list[DescriptionFinding]:
    if link.inertia is None or not (link.mass or 0.0) > 0:
        return []
    moments = np.linalg.eigvalsh(link.inertia)
    if moments[0] < 0 or not moments[2] > 0:
        return []  # No body has it, which check_mass tells.
    points = np.concatenate([corners(shape) for shape in link.shapes])
    reach = np.linalg.norm(points - link.com, axis=1).max()
    about = hull.inertia / hull.volume + parallel(hull.com - link.com)
    largest = moments[2] / link.mass
    filled = np.linalg.eigvalsh(hull.inertia)[2] / hull.volume
    if largest > WIDEST * reach**2:
        return [_size(draft, link, "inertia-oversized", largest**0.5, float(reach))]
    if largest < NARROWEST * filled:
        return [_size(draft, link, "inertia-undersized", largest**0.5, float(filled**0.5))]
    box = bounds(link.shapes)
    # Where the shape lies beside the mass, it says nothing of its axes.
    beside = box is None or away(link.com, box) > 0
    exchanged = None if beside else swapped(link.inertia, about)
    if exchanged is None:
        return []
    return [
        DescriptionFinding(
            code="inertia-swapped",
            severity="info",
            where=at_link(draft, link),
            what=f"its inertia fits its shape only with the axes {exchanged} exchanged",
            fix="check in which frame the inertia is given, and ixx, iyy, izz",
        )
    ]


def _size(
    draft: Draft, link: DraftLink, code: str, result: float, shape: float
) -> DescriptionFinding:
    return DescriptionFinding(
        code=code,
        severity="info",
        where=at_link(draft, link),
        what=f"its radius of gyration is {result:.3g} m, and its shape's is {shape:.3g} m",
        fix="check the unit of the inertia (kg m2) and of the mass (kg)",
    )


def swapped(inertia: Array, shape: Array) -> str | None:
    """Return which axes to exchange so that an inertia fits a shape; None if it fits, or never.

    Both are brought to a trace of 1, so that only the form counts. The exchanged
    one must be far nearer to the shape's than the one given.
    """
    given, wanted = inertia / np.trace(inertia), shape / np.trace(shape)
    distance = float(np.linalg.norm(given - wanted))
    if distance < UNALIKE or float(np.linalg.norm(wanted - np.eye(3) / 3)) < UNEVEN:
        return None
    best, order = min(
        (float(np.linalg.norm(given[np.ix_(p, p)] - wanted)), p) for p in permutations(range(3))
    )
    if best > ALIKE * distance:
        return None
    return " and ".join("xyz"[axis] for axis in range(3) if order[axis] != axis)
