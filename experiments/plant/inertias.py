"""Missing mass and broken inertia: figures that no body has."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, around
from experiments.plant.description import Description, link_in
from experiments.plant.errors import there
from experiments.plant.measure import inertial, moves, solid, sound, total_mass
from morph.arrays import Array

DIAGONAL = ("ixx", "iyy", "izz")
OFF = ("ixy", "ixz", "iyz")


class MissingMass(Defect):
    """A link that moves, with a shape, left without a mass."""

    name: ClassVar[str] = "missing-mass"
    variants: ClassVar[tuple[str, ...]] = ("no inertial", "no mass", "mass of zero")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"mass-missing"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the links that a joint moves."""
        return [link for link in original.links if moves(original, link)]

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the share of the robot's mass that would be lost."""
        mass = inertial(original, site)
        if mass is None or solid(original, site) is None:
            return ""
        share = mass.mass / total_mass(original)
        return f"{mass.mass:.3g} kg, {share:.1%} of the robot" if share > 0.005 else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Take the mass away."""
        robot = copy.parse()
        link = link_in(robot, site)
        whole = block(robot, site)
        mass = there(whole.find("mass"), f"mass of {site}")
        old = mass.get("value", "")
        if variant == "no inertial":
            link.remove(whole)
        elif variant == "no mass":
            whole.remove(mass)
        else:
            mass.set("value", "0")
        copy.write(robot)
        return Done(did=f"{variant}, {old} kg before", places=around(copy, site))


class BrokenInertia(Defect):
    """An inertia that no body can have, from one slip of the pen."""

    name: ClassVar[str] = "broken-inertia"
    variants: ClassVar[tuple[str, ...]] = ("exponent", "sign", "column")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"inertia-broken"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the links."""
        return original.links

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the principal moments, possible now and impossible afterwards."""
        mass = inertial(original, site)
        if mass is None or not sound(mass.moment):
            return ""
        least, middle, most = np.linalg.eigvalsh(_slip(mass.moment, variant)[0])
        # A tenth past what is possible, so that no rounding makes it possible again.
        broken = least < -0.1 * most or most > 1.1 * (least + middle)
        return f"principal moments would be {least:.2g}, {middle:.2g}, {most:.2g}" if broken else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Write the wrong figure."""
        mass = there(inertial(copy, site), f"inertia of {site}")
        changed, did = _slip(mass.moment, variant)
        robot = copy.parse()
        figures = figures_of(robot, site)
        before = inertial_figures(mass.moment)
        for key, value in inertial_figures(changed).items():
            if value != before[key]:
                figures.set(key, f"{value:.9g}")
        copy.write(robot)
        return Done(did=did, places=around(copy, site))


def inertial_figures(moment: Array) -> dict[str, float]:
    """Return the six figures of a URDF's inertia."""
    keys = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return {key: float(moment[place]) for key, place in zip((*DIAGONAL, *OFF), keys, strict=True)}


def _slip(moment: Array, variant: str) -> tuple[Array, str]:
    """Return the inertia after one slip on its largest moment, and what the slip was."""
    place = int(np.argmax(np.diag(moment)))
    changed, key = moment.copy(), DIAGONAL[place]
    if variant == "exponent":
        changed[place, place] *= 10
        return changed, f"{key} ten times as large"
    if variant == "sign":
        changed[place, place] *= -1
        return changed, f"{key} with a minus"
    other = (place + 1) % 3
    changed[place, other] = changed[other, place] = moment[place, place]
    changed[place, place] = moment[place, other]
    return changed, f"{key} written into the column of the product of inertia, and back"


def block(robot: ET.Element, link: str) -> ET.Element:
    """Return a link's inertial element."""
    return there(link_in(robot, link).find("inertial"), f"inertial of {link}")


def figures_of(robot: ET.Element, link: str) -> ET.Element:
    """Return a link's inertia element."""
    return there(block(robot, link).find("inertia"), f"inertia of {link}")
