"""Whether every kilogram of a description's text is simulated or named, link by link."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from morph.body.finding import DescriptionFinding
from morph.body.robot import Robot
from morph.errors import RobotError

LOST = 1e-9
"""Part of the mass that may go missing, as rounding."""

NO_MASS = 1e-13
"""Stated mass, kg, below which a link has none (`morph.body.check.mass.LIGHTEST`)."""

MASSES = ("mass-missing", "inertia-broken")
"""Codes of repairs that may change a mass; each says in words to what."""

GIVEN = re.compile(r"it got (\S+) kg|was taken: (\S+) kg")
"""How such a repair states the mass that a link was given, to four digits."""

PRINTED = 1e-3
"""Relative difference that four printed digits leave open."""


@dataclass(frozen=True, kw_only=True)
class Masses:
    """Masses of a description beside those that are simulated, link by link."""

    stated: float | None
    """kg in the text; None if it could not be counted."""
    simulated: float
    """kg, of the model that MuJoCo steps."""
    named: int
    """Links whose mass differs as a finding at that very link says, value included."""
    silent: tuple[str, ...]
    """Links whose mass differs and of which no finding says so, or says another value."""
    uncounted: str
    """Why the masses of the text could not be counted; empty if they were."""


def judge_masses(path: Path, robot: Robot, findings: Iterable[DescriptionFinding]) -> Masses:
    """Return the masses of a description's text beside those that morph simulates."""
    from morph.body.agreement import read_by_mujoco

    simulated = read_by_mujoco(robot).mass
    try:
        stated = stated_masses(path)
    except ValueError as error:
        return Masses(
            stated=None, simulated=simulated, named=0, silent=(), uncounted=str(error)[:200]
        )
    ours = {link.name: link.mass for link in robot.links}
    told = _told(findings)
    named, silent = 0, []
    for name in {**stated, **ours}:
        before, after = stated.get(name, 0.0), ours.get(name, 0.0)
        if abs(after - before) <= LOST * max(abs(before), NO_MASS):
            continue
        if _is_named(before, after, told.get(name, ())):
            named += 1
        else:
            silent.append(f"{name}: {before:g} kg, simulated {after:g}")
    # What the links say must also be what MuJoCo steps.
    total = sum(ours.values())
    if abs(simulated - total) > LOST * max(total, NO_MASS):
        silent.append(f"all links: {total:g} kg, simulated {simulated:g}")
    return Masses(
        stated=sum(stated.values()),
        simulated=simulated,
        named=named,
        silent=tuple(silent),
        uncounted="",
    )


def stated_masses(path: Path) -> dict[str, float]:
    """Return the mass of every link in the text, kg, zero where none is stated.

    A URDF is read by lxml, a xacro after xacro has expanded it, an MJCF by MuJoCo alone or,
    where its meshes are missing, by lxml.

    Raises:
        ValueError: It cannot be counted.
    """
    if path.suffix.lower() == ".xml":
        return _masses_of_mjcf(path)
    masses: dict[str, float] = {}
    for link in urdf_of(path).xpath("/robot/link"):
        # A name twice is counted twice: whoever loses the second loses its mass.
        name = link.get("name")
        masses[name] = masses.get(name, 0.0) + sum(
            float(mass) for mass in link.xpath("inertial/mass/@value")
        )
    return masses


def urdf_of(path: Path) -> Any:
    """Return the root element of a URDF, or of what a xacro expands to.

    Raises:
        ValueError: It has none.
    """
    from lxml import etree

    # Undeclared prefixes of sensors and plug-ins are no reason not to count masses.
    parser = etree.XMLParser(recover=True)
    if path.suffix.lower() != ".xacro":
        root = etree.parse(path, parser).getroot()
    else:
        root = etree.fromstring(_expanded(path).encode(), parser)
    if root is None:
        raise ValueError("lxml finds no element in it")
    return root


def _expanded(path: Path) -> str:
    """Return what xacro expands a file to, found by morph where its packages must be looked for."""
    import xacro

    try:
        return str(xacro.process_file(str(path)).toxml())
    except Exception:  # Xacro evaluates expressions: anything may come of them.
        from xml.etree import ElementTree

        from morph.body.paths import Files
        from morph.body.source import source_tree

        try:
            return ElementTree.tostring(source_tree(path, Files(path)), encoding="unicode")
        except RobotError as error:
            raise ValueError(f"xacro cannot expand it: {error}") from error


def _masses_of_mjcf(path: Path) -> dict[str, float]:
    import mujoco

    from morph.body.quiet import quiet, silent

    try:
        with quiet(), silent():
            model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return _inertials_of_mjcf(path)
    return {model.body(k).name: float(model.body_mass[k]) for k in range(1, model.nbody)}


def _inertials_of_mjcf(path: Path) -> dict[str, float]:
    """Return the masses of an MJCF whose meshes or terrain are missing, by its text alone."""
    from lxml import etree

    files, bodies = [path], []
    for file in files:
        root = etree.parse(file).getroot()
        files += [file.parent / name for name in root.xpath("//include/@file")]
        bodies += root.xpath("/mujoco/worldbody//body")
        if root.xpath("//compiler[@inertiafromgeom='true']"):
            raise ValueError("its shapes state its masses, and MuJoCo cannot load them")
    for body in bodies:
        # Planes and height fields weigh nothing.
        heavy = body.xpath("geom[not(@type='plane' or @type='hfield')]")
        if body.find("inertial") is None and heavy:
            name = body.get("name")
            raise ValueError(f"the shapes of {name} state its mass, and MuJoCo cannot load them")
    return {
        body.get("name"): sum(float(mass) for mass in body.xpath("inertial/@mass"))
        for body in bodies
    }


def _told(findings: Iterable[DescriptionFinding]) -> dict[str, list[DescriptionFinding]]:
    """Return the repairs that may change a mass, by link."""
    told: dict[str, list[DescriptionFinding]] = {}
    for finding in findings:
        if finding.severity == "repaired" and finding.code in MASSES:
            told.setdefault(finding.where.name, []).append(finding)
    return told


def _is_named(before: float, after: float, findings: Iterable[DescriptionFinding]) -> bool:
    """Return whether a repair at the link is of such a mass, and states the mass simulated."""
    for finding in findings:
        due = before <= NO_MASS if finding.code == "mass-missing" else before < 0.0
        given = GIVEN.search(finding.done)
        if due and given:
            value = float(next(filter(None, given.groups())))
            if abs(after - value) <= PRINTED * value:
                return True
    return False
