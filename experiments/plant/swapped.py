"""Swapped inertia: moments of one link exchanged, or the blocks of two links."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, Places, around
from experiments.plant.description import Description
from experiments.plant.inertias import DIAGONAL, block, figures_of
from experiments.plant.measure import Inertial, Solid, inertial, solid, sound
from experiments.plant.sides import twin

UNLIKE = 2.0
"""Moments whose ratio is below this are not told apart by a shape's hull."""
LEAD = 11340.0
"""kg/m^3, the densest material that robots are weighted with (CRC Handbook)."""
QUITE_DIFFERENT = 4.0
"""Ratio of masses, and of hulls, of two links that nobody would take for each other."""


class SwappedInertia(Defect):
    """Two moments of one link exchanged, or the inertial blocks of two links."""

    name: ClassVar[str] = "swapped-inertia"
    variants: ClassVar[tuple[str, ...]] = ("ixx and izz", "ixx and iyy", "two links")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the codes that name it: a foreign block fits neither the size nor the volume."""
        foreign = {"mass-volume", "inertia-oversized", "inertia-undersized"}
        return frozenset({"inertia-swapped"} | (foreign if variant == "two links" else set()))

    def also(self, variant: str) -> frozenset[str]:
        """Return the code that says that it is not as its twin's."""
        return frozenset({"mass-asymmetric"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the links."""
        return original.links

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return how shape and figures agree now, and would contradict afterwards."""
        shape, mass = solid(original, site), inertial(original, site)
        if shape is None or mass is None or not _good(mass, shape):
            return ""
        if variant == "two links":
            other = _unlike(original, site)
            return f"{_contradiction(original, site, other)}, of {other}" if other else ""
        return _swap_shows(mass, shape, _pair(variant))

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Exchange the figures."""
        other = _unlike(copy, site) if variant == "two links" else ""
        robot = copy.parse()
        own = block(robot, site)
        if other:
            theirs = block(robot, other)
            own[:], theirs[:] = list(theirs), list(own)
            copy.write(robot)
            parts = [around(copy, link) for link in (site, other)]
            return Done(
                did=f"inertial exchanged with {other}'s",
                places=Places(
                    parts=parts[0].parts | parts[1].parts,
                    meshes=parts[0].meshes | parts[1].meshes,
                    partners=frozenset(filter(None, map(twin, (site, other)))),
                ),
            )
        one, two = _pair(variant)
        figures = figures_of(robot, site)
        first, second = figures.get(one, ""), figures.get(two, "")
        figures.set(one, second)
        figures.set(two, first)
        copy.write(robot)
        near = around(copy, site)
        return Done(
            did=f"{one} {first} and {two} {second} exchanged",
            places=Places(
                parts=near.parts,
                meshes=near.meshes,
                partners=frozenset(filter(None, [twin(site)])),
            ),
        )


def _pair(variant: str) -> tuple[str, str]:
    one, two = variant.split(" and ")
    return one, two


def _swap_shows(mass: Inertial, shape: Solid, pair: tuple[str, str]) -> str:
    """Return the ratios of both, if they say the same and the swapped figures are still sound."""
    one, two = (DIAGONAL.index(key) for key in pair)
    own = np.diag(mass.moment)
    seen = np.diag(mass.turn.T @ shape.moment @ mass.turn)
    said, measured = own[one] / own[two], seen[one] / seen[two]
    swapped = mass.moment.copy()
    swapped[one, one], swapped[two, two] = own[two], own[one]
    alike = (said > UNLIKE and measured > UNLIKE) or (said < 1 / UNLIKE and measured < 1 / UNLIKE)
    if not alike or not sound(swapped):
        return ""
    return f"{pair[0]}/{pair[1]} {said:.2g}, of the shape {measured:.2g}"


def _good(mass: Inertial, shape: Solid) -> bool:
    """Return whether a body can have the inertia, and it is as wide as its shape within twice."""
    wide = float(np.trace(mass.moment) / mass.mass / np.trace(shape.moment))
    return sound(mass.moment) and 1 / 4 < wide < 4


def _unlike(original: Description, site: str) -> str:
    """Return the first link, quite different in mass and in volume, whose block cannot fit."""
    mass, shape = inertial(original, site), solid(original, site)
    for other in original.links:
        theirs, body = inertial(original, other), solid(original, other)
        if mass is None or shape is None or theirs is None or body is None:
            continue
        if not _good(theirs, body):
            continue
        ratio = min(theirs.mass / mass.mass, body.volume / shape.volume)
        if ratio > QUITE_DIFFERENT and _contradiction(original, site, other):
            return other
    return ""


def _contradiction(original: Description, site: str, other: str) -> str:
    """Return why the other's inertial block cannot be the site's: too dense, or too wide.

    No body inside a box has a radius of gyration above half the box's diagonal: along each
    side, the variance of its mass is at most a quarter of the side squared (Popoviciu 1935).
    """
    shape, theirs, twins_mass = solid(original, site), inertial(original, other), None
    if shape is None or theirs is None:
        return ""
    density = theirs.mass / shape.volume
    if density > LEAD:
        return f"{density:.0f} kg/m^3 of hull with the block"
    gyration = float(np.sqrt(np.linalg.eigvalsh(theirs.moment)[-1] / theirs.mass))
    if gyration > shape.size / 2:
        return f"radius of gyration {gyration:.3f} m in a shape {shape.size:.3f} m across"
    if twin(site) in original.links:
        twins_mass = inertial(original, twin(site))
    if twins_mass and theirs.mass > QUITE_DIFFERENT * twins_mass.mass:
        return f"{theirs.mass:.3g} kg beside its twin's {twins_mass.mass:.3g} kg with the block"
    return ""
