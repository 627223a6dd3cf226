"""One tree of links that holds two bodies whose parts bear matching names."""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import Any

import mujoco

from morph.body.vary.match import WORLD, parents
from morph.errors import RobotError

Element = ElementTree.Element


@dataclass(frozen=True, kw_only=True)
class Union:
    """The links, joints and actuators of both bodies, in one order."""

    parents: dict[str, str]
    """Every link's parent, by name; a link after its parent."""
    joints: dict[str, list[str]]
    """Every link's joints."""
    actuators: dict[str, str]
    """Every actuator's joint."""
    between: frozenset[str]
    """Links of one body that carry a link of both."""


def union(first: Any, second: Any) -> Union:
    """Return the tree that becomes either of two specs when links are left out.

    Where a link of both hangs on links of one, these are put in a row: those
    of the first body, then those of the second.

    Raises:
        RobotError: A link of both hangs on different links of both, no tree
            holds both bodies, or a link would have a free joint and others.
    """
    ours, theirs = parents(first), parents(second)
    result = ours | {name: parent for name, parent in theirs.items() if name not in ours}
    joints = {name: _joints(name, first, second) for name in result}
    placed: dict[str, str] = {}
    between: set[str] = set()
    for name in (name for name in ours if name in theirs):
        rows = [_row(name, tree, other) for tree, other in ((ours, theirs), (theirs, ours))]
        if rows[0][-1] != rows[1][-1]:
            raise _tangled(
                name, f"it hangs below {rows[0][-1]!r} in one and {rows[1][-1]!r} in the other"
            )
        # From the link up: the second body's, the first body's, what carries both.
        row = [name, *rows[1][:-1], *rows[0]]
        between |= set(row[1:-1])
        for child, parent in itertools.pairwise(row):
            if placed.setdefault(child, parent) != parent:
                raise _tangled(child, f"it would hang on {placed[child]!r} and on {parent!r}")
    tree = _ordered(result | placed)
    for name, parent in tree.items():
        _check_freedoms(name, parent, [first.joint(j) or second.joint(j) for j in joints[name]])
    return Union(
        parents=tree,
        joints=joints,
        actuators=_actuators(first, second),
        between=frozenset(between),
    )


def skeleton(mjcf: str, tree: Union) -> str:
    """Return a body's description with the links, joints and actuators that it lacks.

    What is new has a name and no numbers. Keyframes go if joints were added.
    """
    root = ElementTree.fromstring(mjcf)
    world = root.find("worldbody")
    if world is None:
        world = ElementTree.SubElement(root, "worldbody")
    bodies = {str(element.get("name")): element for element in world.iter("body")}
    had = {str(element.get("name")) for element in world.iter() if element.tag in JOINTS}
    for element in (world, *bodies.values()):
        for child in element.findall("body"):
            element.remove(child)
    bodies[WORLD] = world
    for name, parent in tree.parents.items():
        element = bodies.setdefault(name, Element("body", name=name))
        bodies[parent].append(element)
        _order(element, JOINTS, "joint", tree.joints[name])
    drives = root.find("actuator")
    if drives is None:
        drives = ElementTree.SubElement(root, "actuator")
    _order(drives, tuple({each.tag for each in drives}), "general", list(tree.actuators))
    for element in drives:
        element.set("joint", tree.actuators[str(element.get("name"))])
    if had != {joint for joints in tree.joints.values() for joint in joints}:
        for keys in root.findall("keyframe"):
            root.remove(keys)
    return ElementTree.tostring(root, encoding="unicode")


FREEDOMS = {
    mujoco.mjtJoint.mjJNT_FREE: 6,
    mujoco.mjtJoint.mjJNT_BALL: 3,
    mujoco.mjtJoint.mjJNT_SLIDE: 1,
    mujoco.mjtJoint.mjJNT_HINGE: 1,
}
"""Degrees of freedom of each kind of joint."""

JOINTS = ("joint", "freejoint")
"""The elements that are joints of a body."""


def _row(name: str, tree: dict[str, str], other: dict[str, str]) -> list[str]:
    row = [tree[name]]
    while row[-1] != WORLD and row[-1] not in other:
        row.append(tree[row[-1]])
    return row


def _check_freedoms(name: str, parent: str, joints: list[Any]) -> None:
    free = sum(FREEDOMS[joint.type] for joint in joints)
    floats = any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in joints)
    if free > 6 or (floats and (len(joints) > 1 or parent != WORLD)):
        raise RobotError(
            f"between the bodies it would move by {', '.join(repr(j.name) for j in joints)} "
            f"on {parent!r}, which no link can",
            where=f"link {name!r}",
            fix="describe how it moves by the same kinds of joints in both bodies, or give a "
            "mapping that leaves it unmatched",
        )


def _ordered(tree: dict[str, str]) -> dict[str, str]:
    done: dict[str, str] = {}
    left = dict(tree)
    while left:
        ready = [name for name, parent in left.items() if parent == WORLD or parent in done]
        if not ready:
            raise _tangled(next(iter(left)), "its links would hang from each other in a circle")
        done |= {name: left.pop(name) for name in ready}
    return done


def _joints(name: str, first: Any, second: Any) -> list[str]:
    # Each body's own order is kept: what follows a joint moves with it.
    bodies = first.body(name), second.body(name)
    ours, theirs = ([str(each.name) for each in (body.joints if body else ())] for body in bodies)
    results: list[str] = []
    for joint in ours:
        if joint in theirs:
            results += [each for each in theirs[: theirs.index(joint)] if each not in results]
        results.append(joint)
    return results + [each for each in theirs if each not in results]


def _actuators(first: Any, second: Any) -> dict[str, str]:
    results = {each.name: str(each.target) for each in first.actuators}
    return results | {e.name: str(e.target) for e in second.actuators if e.name not in results}


def _order(parent: Element, tags: tuple[str, ...], tag: str, names: list[str]) -> None:
    had = {str(child.get("name")): child for child in parent if child.tag in tags}
    for child in had.values():
        parent.remove(child)
    ordered = [had[name] if name in had else Element(tag, name=name) for name in names]
    # An inertial element comes first; the order of joints is that of their names here.
    at = 1 if parent.find("inertial") is not None else 0
    parent[at:at] = ordered


def _tangled(name: str, what: str) -> RobotError:
    return RobotError(
        f"no tree of links holds both bodies: {what}",
        where=f"link {name!r}",
        fix="give a mapping that leaves this link, or those above it, unmatched",
    )
