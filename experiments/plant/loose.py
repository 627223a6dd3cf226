"""Dangling joint and lost base: a tree that falls apart."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, Places
from experiments.plant.description import (
    Description,
    child_of,
    joint_in,
    link_in,
    named,
    parent_of,
)
from experiments.plant.measure import inertial, total_mass
from experiments.plant.tree import end_of


class DanglingJoint(Defect):
    """A joint to a link that is not there."""

    name: ClassVar[str] = "dangling-joint"
    variants: ClassVar[tuple[str, ...]] = ("parent typo", "child typo", "link gone", "no child")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"dangling-joint"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the joints."""
        return original.joints

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return that both ends are there."""
        joint = joint_in(original.robot, site)
        ends = {parent_of(joint), child_of(joint)}
        there = ends <= set(original.links) and not {_typo(end) for end in ends} & set(
            original.links
        )
        return f"joins {' and '.join(sorted(ends))}, both there" if there else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Mistype one end, or take it out."""
        robot = copy.parse()
        joint = joint_in(robot, site)
        tag = "parent" if variant == "parent typo" else "child"
        end = end_of(joint, tag)
        link, parts = end.get("link", ""), {site}
        if variant == "no child":
            joint.remove(end)
        elif variant == "link gone":
            robot.remove(link_in(robot, link))
            parts |= {named(j) for j in robot.findall("joint") if parent_of(j) == link}
        else:
            end.set("link", _typo(link))
            parts.add(_typo(link))
        copy.write(robot)
        return Done(did=f"{variant} {link}", places=Places(parts=frozenset({*parts, link})))


class LostBase(Defect):
    """What ties the base to the rest is gone, so that the description falls apart."""

    name: ClassVar[str] = "lost-base"
    variants: ClassVar[tuple[str, ...]] = ("joint gone", "base gone", "both gone")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"lost-base"})

    def also(self, variant: str) -> frozenset[str]:
        """Return the code that names the missing base by the joints that want it."""
        return frozenset({"dangling-joint"} if variant == "base gone" else ())

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the joints at the base, or the first of them where the base goes."""
        at_base = _at_base(original.robot, original.base)
        return at_base if variant == "joint gone" else at_base[:1]

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return what would fall off: a tenth of the mass or more, not the whole of the robot."""
        limbs = [
            original.below(child_of(joint_in(original.robot, name)))
            for name in (
                [site] if variant == "joint gone" else _at_base(original.robot, original.base)
            )
        ]
        whole = total_mass(original)
        shares = [
            sum(one.mass for link in limb if (one := inertial(original, link))) / whole
            for limb in limbs
        ]
        heavy = [share for share in shares if share > 0.1]
        if variant == "joint gone":
            return f"{heavy[0]:.0%} of the mass falls off" if heavy else ""
        if variant == "both gone" and len(heavy) < 2:
            return ""
        return f"{len(shares)} limbs fall off, {len(heavy)} of them heavy" if heavy else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Take out the joint, the base, or the base with its joints."""
        robot, base = copy.parse(), copy.base
        at_base = _at_base(robot, base)
        if variant != "joint gone":
            robot.remove(link_in(robot, base))
        gone = {"joint gone": [site], "base gone": [], "both gone": at_base}[variant]
        loose = {site} if variant == "joint gone" else set(at_base)
        children = {child_of(joint_in(robot, name)) for name in loose}
        for name in gone:
            robot.remove(joint_in(robot, name))
        copy.write(robot)
        return Done(
            did=f"{variant}: {base if variant != 'joint gone' else site}",
            places=Places(parts=frozenset({base, *loose, *children})),
        )


def _at_base(robot: ET.Element, base: str) -> list[str]:
    return [named(joint) for joint in robot.findall("joint") if parent_of(joint) == base]


def _typo(name: str) -> str:
    """Return a name with its middle letter forgotten."""
    return name[: len(name) // 2] + name[len(name) // 2 + 1 :]
