"""Duplicate name and cyclic tree: a tree that is none."""

from __future__ import annotations

import copy as copies
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
from experiments.plant.errors import there


class DuplicateName(Defect):
    """A block that was copied, and one name in it not changed."""

    name: ClassVar[str] = "duplicate-name"
    variants: ClassVar[tuple[str, ...]] = ("joint", "link", "link twice")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"duplicate-name"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return joints or links but the first, whose name the others take."""
        return (original.joints if variant == "joint" else original.links)[1:]

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return that every name is there once."""
        known = original.joints if variant == "joint" else original.links
        return f"{len(known)} names, each once" if len(set(known)) == len(known) else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Give the site the name of the part before it in the file, or put its block in twice."""
        robot = copy.parse()
        if variant == "link twice":
            link = link_in(robot, site)
            robot.insert(list(robot).index(link) + 1, copies.deepcopy(link))
            copy.write(robot)
            return Done(did="block stands twice", places=Places(parts=frozenset({site})))
        known = copy.joints if variant == "joint" else copy.links
        taken = known[known.index(site) - 1]
        if variant == "joint":
            joint_in(robot, site).set("name", taken)
        else:
            _rename_link(robot, site, taken)
        copy.write(robot)
        return Done(
            did=f"{variant} {site} became a second {taken}",
            places=Places(parts=frozenset({taken, site})),
        )


class CyclicTree(Defect):
    """A link that hangs from what hangs from it, or from two parents."""

    name: ClassVar[str] = "cyclic-tree"
    variants: ClassVar[tuple[str, ...]] = ("own grandchild", "itself", "second parent")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"cyclic-tree"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the joints."""
        return original.joints

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the limb that hangs from the joint."""
        limb = original.below(child_of(joint_in(original.robot, site)))
        if variant == "second parent":
            return f"{limb[0]} hangs from one parent" if _foreign(original, site) else ""
        enough = len(limb) > 2 or variant == "itself"
        return f"{len(limb)} links hang from it, in no circle" if enough else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Close the circle."""
        robot = copy.parse()
        joint = joint_in(robot, site)
        limb = copy.below(child_of(joint))
        if variant == "second parent":
            # As people try to write a four-bar, which a URDF cannot hold.
            foreign = _foreign(copy, site)
            second = copies.deepcopy(joint)
            second.set("name", f"{site}_closing")
            end_of(second, "parent").set("link", foreign)
            robot.append(second)
            copy.write(robot)
            return Done(
                did=f"{limb[0]} also hangs from {foreign}",
                places=Places(parts=frozenset({site, f"{site}_closing", limb[0]})),
            )
        circle = [limb[0]]
        if variant == "own grandchild":
            circle = _chain(copy, limb[0], limb[-1])
        end_of(joint, "parent").set("link", circle[-1])
        copy.write(robot)
        joints = {copy.parents[link] for link in circle}
        return Done(
            did=f"{limb[0]} hangs from {circle[-1]}",
            places=Places(parts=frozenset({site, *circle} | joints)),
        )


def _rename_link(robot: ET.Element, old: str, new: str) -> None:
    """Rename a link and all that refers to it, as one who copied the whole block would."""
    link_in(robot, old).set("name", new)
    for joint in robot.findall("joint"):
        for tag in ("parent", "child"):
            end = joint.find(tag)
            if end is not None and end.get("link") == old:
                end.set("link", new)


def end_of(joint: ET.Element, tag: str) -> ET.Element:
    """Return the parent or child element of a joint."""
    return there(joint.find(tag), f"{tag} of {named(joint)}")


def _chain(description: Description, top: str, low: str) -> list[str]:
    """Return the links from one to another that hangs below it."""
    chain = [low]
    while chain[0] != top:
        joint = joint_in(description.robot, description.parents[chain[0]])
        chain.insert(0, parent_of(joint))
    return chain


def _foreign(description: Description, joint: str) -> str:
    """Return the last link that is neither above nor below a joint's child, or nothing."""
    element = joint_in(description.robot, joint)
    kin = {*description.below(child_of(element)), parent_of(element), description.base}
    others = [link for link in description.links if link not in kin]
    return others[-1] if others else ""
