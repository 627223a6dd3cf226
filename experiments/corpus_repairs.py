"""Whether a difference to Pinocchio's reading of a file is its named repairs, and nothing else."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from experiments.corpus_masses import urdf_of
from morph.body.finding import DescriptionFinding
from morph.body.robot import Link, Robot
from morph.errors import RobotError

AGREE = 1e-9
"""Greatest relative difference of two readings that agree (`morph.body.agreement.difference`)."""


def judge_difference(
    path: Path, robot: Robot, findings: Sequence[DescriptionFinding]
) -> tuple[bool, str]:
    """Return whether a difference to Pinocchio's reading is the named repairs, and which.

    The repairs are made anew in the text of the file, each at the very link or joint that its
    finding names and in nothing but what its code is about, and Pinocchio reads that. It is the
    test of undoing them in what is simulated, turned round: MuJoCo does not load a mass of zero.
    If the difference is gone, it was nothing but them. Then each code's repairs are undone by
    themselves: those whose undoing brings the difference back are what explains it.

    Returns:
        Whether no difference is left, and the codes that explain it, with commas between.
    """
    repairs = [one for one in findings if one.severity == "repaired" and one.code in REPAIRED]
    if path.suffix.lower() == ".xml" or _left(path, robot, repairs) > AGREE:
        return False, ""
    codes = sorted({finding.code for finding in repairs})
    needed = [
        code
        for code in codes
        if _left(path, robot, [one for one in repairs if one.code != code]) > AGREE
    ]
    return bool(needed), ", ".join(needed)


def _left(path: Path, robot: Robot, repairs: Sequence[DescriptionFinding]) -> float:
    """Return how far MuJoCo's reading is from Pinocchio's of the file with some repairs made."""
    from lxml import etree

    from morph.body.agreement import difference, read_by_mujoco, read_by_pinocchio

    root = urdf_of(path)
    for finding in repairs:
        REPAIRED[finding.code](root, robot, finding)
    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder) / "repaired.urdf"
        text.write_bytes(etree.tostring(root))
        try:
            return difference(read_by_mujoco(robot), read_by_pinocchio(replace(robot, source=text)))
        except RobotError:
            return float("inf")


def _mass(root: Any, robot: Robot, finding: DescriptionFinding) -> None:
    """Give the link all of the inertial that is simulated: it had no mass to keep."""
    for element, link in _links(root, robot, finding):
        _write(element, link, mass=link.mass, com=link.com)


def _inertia(root: Any, robot: Robot, finding: DescriptionFinding) -> None:
    """Give the link the inertia that is simulated; a mass above zero and its place stay."""
    for element, link in _links(root, robot, finding):
        mass = float(element.xpath("number(inertial/mass/@value)"))
        if mass > 0.0:
            place = element.xpath("string(inertial/origin/@xyz)").split() or ("0", "0", "0")
            x, y, z = map(float, place)
            _write(element, link, mass=mass, com=(x, y, z))
        else:
            _write(element, link, mass=link.mass, com=link.com)


def _links(root: Any, robot: Robot, finding: DescriptionFinding) -> list[tuple[Any, Link]]:
    ours = {link.name: link for link in robot.links}
    name = finding.where.name
    return [(one, ours[name]) for one in _named("link", root, finding) if name in ours]


def _named(what: str, root: Any, finding: DescriptionFinding) -> list[Any]:
    return list(root.xpath(f"/robot/{what}[@name=$name]", name=finding.where.name))


def _write(element: Any, link: Link, *, mass: float, com: tuple[float, float, float]) -> None:
    from lxml import etree

    for before in element.findall("inertial"):
        element.remove(before)
    inertial = etree.SubElement(element, "inertial")
    etree.SubElement(inertial, "origin", xyz=" ".join(map(repr, com)), rpy="0 0 0")
    etree.SubElement(inertial, "mass", value=repr(mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = {name: repr(value) for name, value in zip(names, link.inertia, strict=True)}
    etree.SubElement(inertial, "inertia", values)


def _weld(root: Any, robot: Robot, finding: DescriptionFinding) -> None:
    """Weld the joint if its finding says so; another range changes no inertia."""
    for joint in _named("joint", root, finding):
        if finding.done.startswith("it was welded"):
            joint.set("type", "fixed")


def _axis(root: Any, robot: Robot, finding: DescriptionFinding) -> None:
    """Turn the joint about the axis that is simulated."""
    ours = {joint.name: joint for joint in robot.joints}
    for joint in _named("joint", root, finding):
        if joint.get("name") in ours:
            for axis in joint.findall("axis"):
                axis.set("xyz", " ".join(map(repr, ours[joint.get("name")].axis)))


def _unfollow(root: Any, robot: Robot, finding: DescriptionFinding) -> None:
    """Let the joint follow no other."""
    for joint in _named("joint", root, finding):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)


REPAIRED = {
    "mass-missing": _mass,
    "inertia-missing": _inertia,
    "inertia-broken": _inertia,
    "limit-range": _weld,
    "joint-axis": _axis,
    "mimic": _unfollow,
}
"""What a repair of each code changes in a file, made anew apart from morph's checks."""
