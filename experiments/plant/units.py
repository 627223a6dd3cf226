"""Unit swap: millimetres read as metres, metres as millimetres, grams as kilograms."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, Places, around, mesh_names
from experiments.plant.description import (
    Description,
    child_of,
    joint_in,
    link_in,
    numbers,
    text_of,
)
from experiments.plant.errors import there
from experiments.plant.measure import inertial, solid, triangles
from experiments.plant.mesh_file import REWRITABLE, rewrite

OSMIUM = 22590.0
"""kg/m^3, the densest element at room temperature (CRC Handbook of Chemistry and Physics)."""


class UnitSwap(Defect):
    """A length or a mass of one part a thousand times too large or too small."""

    name: ClassVar[str] = "unit-swap"
    variants: ClassVar[tuple[str, ...]] = (
        "mesh in mm",
        "scale for mm",
        "mass in g",
        "mesh in mm",
        "centre in mm",
        "joint in mm",
    )

    def codes(self, variant: str) -> frozenset[str]:
        """Return the codes of findings that name it."""
        named = {
            "mass in g": {"mass-volume"},
            "centre in mm": {"length-units", "mesh-moved"},
            "joint in mm": {"length-units"},
        }
        return frozenset(named.get(variant, {"mesh-units"}))

    def also(self, variant: str) -> frozenset[str]:
        """Return codes that say the same with other words."""
        named = {"mass in g": {"inertia-undersized"}, "joint in mm": {"mesh-units"}}
        return frozenset(named.get(variant, ()))

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return links, or the joints whose origin is in millimetres."""
        return original.joints if variant == "joint in mm" else original.links

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the size that is right now, and would be absurd afterwards."""
        if variant == "joint in mm":
            return _far(original, site)
        shape, mass = solid(original, site), inertial(original, site)
        if shape is None or mass is None or not 0.02 <= shape.size <= 3.0:
            return ""
        if variant == "mass in g":
            density = mass.mass / shape.volume
            heavy = 30 <= density <= 1.2 * OSMIUM and 1000 * density > 1.2 * OSMIUM
            return f"{density:.0f} kg/m^3 of hull, a thousandfold past osmium" if heavy else ""
        if variant == "centre in mm":
            out = float(np.linalg.norm(mass.centre)) * 1000
            clear = out > 5 * shape.size and np.linalg.norm(mass.centre) < shape.size
            return f"centre {out / 1000:.3f} m off, shape {shape.size:.2f} m" if clear else ""
        mesh = _mesh(original, site, rewritable=variant == "mesh in mm")
        return f"shape {shape.size:.3f} m, its own mesh {mesh}" if mesh else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Write one figure, or one mesh, in the other unit."""
        if variant in ("mesh in mm", "scale for mm"):
            return _mesh_swapped(copy, site, variant)
        robot = copy.parse()
        if variant == "joint in mm":
            joint = joint_in(robot, site)
            origin, name = joint.find("origin"), "xyz"
            places = Places(parts=frozenset({site, child_of(joint)}))
        else:
            tag, name = ("mass", "value") if variant == "mass in g" else ("origin", "xyz")
            origin = link_in(robot, site).find(f"inertial/{tag}")
            places = around(copy, site)
        origin = there(origin, f"origin of {site}")
        old = origin.get(name, "")
        origin.set(name, text_of(1000 * value for value in numbers(origin, name, "")))
        copy.write(robot)
        return Done(did=f"{variant}: {old} became {origin.get(name)}", places=places)


def _far(original: Description, joint: str) -> str:
    """Return how far a joint would be off, if that is far beyond the robot's own reach."""
    reach = sum(
        float(np.linalg.norm(numbers(element.find("origin"), "xyz", "0 0 0")))
        for element in original.robot.findall("joint")
    )
    origin = joint_in(original.robot, joint).find("origin")
    off = 1000 * float(np.linalg.norm(numbers(origin, "xyz", "0 0 0")))
    return f"{off:.0f} m, all joints together reach {reach:.2f} m" if off > 5 * reach > 0 else ""


def _mesh(original: Description, link: str, *, rewritable: bool) -> str:
    """Return the path of a link's first mesh, if it is there and can be rewritten where asked."""
    for uri in original.meshes(link):
        file = original.file_of(uri)
        if file is None or (rewritable and file.suffix.lower() not in REWRITABLE):
            continue
        # In its file's own units: larger ones are in millimetres already, with a scale.
        if 0.02 <= float(np.linalg.norm(triangles(file).extents)) <= 3.0:
            return uri
    return ""


def _mesh_swapped(copy: Description, link: str, variant: str) -> Done:
    uri = _mesh(copy, link, rewritable=variant == "mesh in mm")
    file = there(copy.file_of(uri), f"mesh of {link}")
    if variant == "mesh in mm":
        users = copy.users(file)
        rewrite(file, lambda mesh: mesh.apply_scale(1000.0))
        return Done(
            did=f"{file.name} saved in mm, scale left",
            places=Places(parts=frozenset(users), meshes=mesh_names([uri])),
        )
    robot = copy.parse()
    for mesh in link_in(robot, link).iter("mesh"):
        if mesh.get("filename") == uri:
            scale = [0.001 * value for value in numbers(mesh, "scale", "1 1 1")]
            mesh.set("scale", text_of(scale))
    copy.write(robot)
    return Done(did=f"scale 0.001 on {uri}, which is in m", places=around(copy, link))
