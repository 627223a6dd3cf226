"""Reading URDF into a draft, as it stands; the checks say what is wrong with it."""

from __future__ import annotations

import difflib
from dataclasses import replace
from pathlib import Path

import numpy as np

from morph.body.draft import MOVING, Draft, DraftJoint, DraftLink, DraftMimic, Pose, Shape
from morph.body.finding import DescriptionFinding, Where
from morph.body.numbers import SMALLEST, maybe_number, number, numbers, rotation
from morph.body.refusal import about_file, refusal
from morph.body.urdf_elements import GEOMETRIES, strangers
from morph.body.xml import Element
from morph.errors import RobotError

MOST_LINKS = 1000
"""Most links, and most joints; five times those of the largest robot known to us."""

MOST_SHAPES = 4000
"""Most visual and collision shapes; ten times those of the largest robot known to us."""

LONGEST_NAME, LONGEST_FILE = 200, 1000
"""Most characters of a name, and of a mesh's path."""


def draft_urdf(tree: Element, path: Path) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft that a URDF states, and what its text alone shows.

    Raises:
        DescriptionRefused: Attributes are no numbers; each is a finding.
        RobotError: The text cannot be understood: no robot, a name that is missing,
            more parts than a robot has; the line is named.
    """
    if tree.tag != "robot":
        raise RobotError(
            f"its first element is <{tree.tag}>, not <robot>",
            where=tree.place,
            fix="give a URDF or an MJCF; convert an SDF with gz sdf or a tool of its maker",
        )
    _few(tree)
    findings = strangers(tree)
    colours = {
        material.get("name", ""): colour
        for material in tree.children("material")
        if (colour := _colour(material, {})) is not None
    }
    links: list[DraftLink] = []
    joints: list[DraftJoint] = []
    for element in tree.children("link", "joint"):
        name = _named(element)
        try:
            if element.tag == "link":
                links.append(_link(element, name, colours))
            else:
                joint, noted = _joint(element, name, path)
                joints.append(joint)
                findings.extend(noted)
        except RobotError as error:
            result = about_file(error, path, code="ill-typed")
            where = replace(result.where, kind=element.tag, name=name)
            findings.append(replace(result, where=where))
    if any(finding.code == "ill-typed" for finding in findings):
        raise refusal(findings)
    name = _named(tree) if tree.get("name") else path.stem
    return Draft(name=name, file=path, links=tuple(links), joints=tuple(joints)), findings


def _few(tree: Element) -> None:
    shapes = (tag for link in tree.children("link") for tag in link.children("visual", "collision"))
    counts = {
        "links": (sum(1 for _ in tree.children("link")), MOST_LINKS),
        "joints": (sum(1 for _ in tree.children("joint")), MOST_LINKS),
        "shapes": (sum(1 for _ in shapes), MOST_SHAPES),
    }
    for parts, (count, most) in counts.items():
        if count > most:
            raise RobotError(
                f"has {count} {parts}; a robot has {most} at most",
                where=tree.place,
                fix="describe one robot a file",
            )
    if not counts["links"][0]:
        raise RobotError("has no link", where=tree.place, fix="describe at least one <link>")


def _named(element: Element) -> str:
    name = element.get("name", "")
    if not name.strip():
        raise RobotError(
            f"a <{element.tag}> has no name", where=element.place, fix="give it a name of its own"
        )
    if len(name) > LONGEST_NAME:
        raise RobotError(
            f"the name {name[:40]!r}... has {len(name)} characters",
            where=element.place,
            fix="give it a shorter name",
        )
    return name


def _pose(element: Element | None) -> Pose:
    origin = None if element is None else element.child("origin")
    if origin is None:
        return Pose()
    roll, pitch, yaw = numbers(origin, "rpy", 3, (0, 0, 0)).tolist()
    return Pose(position=numbers(origin, "xyz", 3, (0, 0, 0)), rotation=rotation(roll, pitch, yaw))


def _link(element: Element, name: str, colours: dict[str, tuple[float, ...]]) -> DraftLink:
    shapes = [
        shape
        for role in ("visual", "collision")
        for child in element.children(role)
        if (shape := _shape(child, role, colours)) is not None
    ]
    inertial = element.child("inertial")
    mass = inertia = None
    frame = _pose(inertial)
    if inertial is not None:
        held = inertial.child("mass")
        mass = None if held is None else number(held, "value", 0.0)
        held = inertial.child("inertia")
        if held is not None:
            xx, yy, zz, xy, xz, yz = (
                number(held, key, 0.0) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            )
            along = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            inertia = frame.rotation @ along @ frame.rotation.T
            inertia = (inertia + inertia.T) / 2
    return DraftLink(
        name=name,
        mass=mass,
        com=frame.position,
        inertia=inertia,
        inertia_from="description" if mass else "none",
        shapes=tuple(shapes),
        line=element.line,
    )


def _shape(element: Element, role: str, colours: dict[str, tuple[float, ...]]) -> Shape | None:
    geometry = element.child("geometry")
    if geometry is None:
        return None
    held = next(geometry.children(*GEOMETRIES), None)
    if held is None:
        return None
    size: tuple[float, ...] = ()
    if held.tag == "box":
        size = tuple(numbers(held, "size", 3, (0, 0, 0)).tolist())
    elif held.tag != "mesh":
        size = (number(held, "radius", 0.0),)
        if held.tag != "sphere":
            size = (*size, number(held, "length", 0.0))
    x, y, z = numbers(held, "scale", 3, (1, 1, 1)).tolist()
    material = element.child("material")
    colour = None if material is None else _colour(material, colours)
    return Shape(
        role=role,
        kind=held.tag,
        pose=_pose(element),
        size=tuple(0.0 if abs(edge) <= SMALLEST else edge for edge in size),
        file=held.get("filename", "")[:LONGEST_FILE] if held.tag == "mesh" else "",
        scale=(x, y, z),
        colour=None if colour is None else (colour[0], colour[1], colour[2], colour[3]),
        line=held.line,
    )


def _colour(material: Element, known: dict[str, tuple[float, ...]]) -> tuple[float, ...] | None:
    held = material.child("color")
    if held is None:
        return known.get(material.get("name", ""))
    return tuple(np.clip(numbers(held, "rgba", 4, (0.7, 0.7, 0.7, 1)), 0, 1).tolist())


def _end(element: Element, tag: str) -> str:
    held = element.child(tag)
    # A name longer than any link's is no link's, however it goes on.
    return "" if held is None else held.get("link", "")[: LONGEST_NAME + 1]


def _joint(element: Element, name: str, path: Path) -> tuple[DraftJoint, list[DescriptionFinding]]:
    kind = element.get("type", "")
    findings = []
    if kind not in (*MOVING, "fixed") or kind == "ball":
        findings.append(_kind(element, name, kind[:80]))
        kind = "fixed"
    axis = element.child("axis")
    limit, dynamics = element.child("limit"), element.child("dynamics")
    mimic = element.child("mimic")
    vector = np.array((1.0, 0, 0)) if axis is None else numbers(axis, "xyz", 3, (1, 0, 0))
    length = float(np.linalg.norm(vector))
    if kind not in ("fixed", "floating") and abs(length - 1) > 1e-3:
        findings.append(_axis(name, vector, length, path, axis.line if axis is not None else 0))
    return (
        DraftJoint(
            name=name,
            kind=kind,
            parent=_end(element, "parent"),
            child=_end(element, "child"),
            pose=_pose(element),
            axis=vector / length if length > 0 else np.array((1.0, 0, 0)),
            lower=None if limit is None else maybe_number(limit, "lower"),
            upper=None if limit is None else maybe_number(limit, "upper"),
            effort=None if limit is None else maybe_number(limit, "effort"),
            velocity=None if limit is None else maybe_number(limit, "velocity"),
            damping=0.0 if dynamics is None else number(dynamics, "damping", 0.0),
            friction=0.0 if dynamics is None else number(dynamics, "friction", 0.0),
            mimic=None
            if mimic is None
            else DraftMimic(
                joint=mimic.get("joint", "")[: LONGEST_NAME + 1],
                ratio=number(mimic, "multiplier", 1.0),
                offset=number(mimic, "offset", 0.0),
            ),
            line=element.line,
        ),
        findings,
    )


def _kind(element: Element, name: str, kind: str) -> DescriptionFinding:
    near = difflib.get_close_matches(kind, (*MOVING, "fixed"), n=1, cutoff=0.0)
    return DescriptionFinding(
        code="joint-kind",
        severity="refused",
        where=Where(kind="joint", name=name, file=element.file, line=element.line),
        what=f"it is of the type {kind!r}, which URDF does not know",
        fix=f"write {near[0] if near else 'revolute'}, or another type of URDF",
    )


def _axis(
    name: str, vector: np.ndarray, length: float, path: Path, line: int
) -> DescriptionFinding:
    zero = length == 0
    return DescriptionFinding(
        code="joint-axis",
        severity="refused" if zero else "repaired",
        where=Where(kind="joint", name=name, file=str(path), line=line),
        what=f"its axis is {' '.join(f'{value:g}' for value in vector)}, of length {length:g}",
        done="nothing" if zero else "the axis was brought to length 1",
        fix="give the direction that it turns about or slides along, of length 1",
    )
