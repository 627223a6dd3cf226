"""Reading CAD meshes and a table of their joints into a draft."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.body.cad_table import UNITS, AssemblyTable, JointTable, PartTable, read_assembly
from morph.body.draft import Draft, DraftJoint, DraftLink, Pose, Shape
from morph.body.mesh import Mesh, mesh_content, read_mesh
from morph.body.numbers import rotation
from morph.body.paths import Files
from morph.body.solids import solid
from morph.body.table import Place
from morph.errors import RobotError

METRIC = (".3mf", ".dae", ".step", ".stp")
"""Endings of the formats that state their unit, so that `read_mesh` gives metres."""


def read_cad(path: Path) -> Draft:
    """Return the draft that an `assembly.toml` states: its keys stand in `cad_table`.

    A link's inertia is that of its mesh, filled evenly to its mass as weighed
    (`inertia_from` is `measured`), or at its density (`mesh x density`); a
    mesh that is not closed counts as its convex hull. Whether links and joints
    make one tree is for the checks to say.

    Raises:
        RobotError: The table or a mesh cannot be used; the line is named.
    """
    assembly, place = read_assembly(path)
    files = Files(path)
    places = _places(assembly)
    meshes: dict[Path, Mesh] = {}
    links = tuple(
        _link(part, assembly, _at(place, "link", index), files, places.get(part.name), meshes)
        for index, part in enumerate(assembly.link)
    )
    joints = tuple(
        _joint(joint, assembly, _at(place, "joint", index), places)
        for index, joint in enumerate(assembly.joint)
    )
    return Draft(name=assembly.name, file=path, links=links, joints=joints)


def _at(place: Place, section: str, index: int) -> Place:
    return Place(file=place.file, text=place.text, section=section, index=index)


def _places(assembly: AssemblyTable) -> dict[str, Array]:
    """Return where each link's origin is in the assembly's frame: at its joint.

    Empty unless that is the frame in which all is given.
    """
    if assembly.frame == "link":
        return {}
    unit = UNITS[assembly.unit]
    return {joint.child: unit * np.array(joint.origin) for joint in assembly.joint}


def _link(
    part: PartTable,
    assembly: AssemblyTable,
    place: Place,
    files: Files,
    origin: Array | None,
    meshes: dict[Path, Mesh],
) -> DraftLink:
    path = _file(part, place, files)
    if path not in meshes:
        meshes[path] = _mesh(path)
    metres = 1.0 if path.suffix.lower() in METRIC else UNITS[part.unit or assembly.unit]
    line = _line(place, "name")
    pose = Pose() if origin is None else Pose(position=-origin)
    visual, collision = (
        Shape(
            role=role,
            kind="mesh",
            pose=pose,
            file=part.mesh,
            path=path,
            scale=(metres, metres, metres),
            mesh=meshes[path],
            line=line,
        )
        for role in ("visual", "collision")
    )
    filled = solid(visual)
    if filled is None:
        raise RobotError(
            f"the mesh {part.mesh!r} of the link {part.name!r} encloses no volume",
            where=place.key("mesh"),
            fix="export the part as a solid",
        )
    density = part.density_kg_m3 or assembly.density_kg_m3 or 0.0
    mass = part.mass_kg if part.mass_kg is not None else filled.volume * density
    return DraftLink(
        name=part.name,
        mass=mass,
        com=filled.com,
        inertia=filled.inertia * (mass / filled.volume),
        inertia_from="mesh x density" if part.mass_kg is None else "measured",
        shapes=(visual, collision),
        line=line,
    )


def _file(part: PartTable, place: Place, files: Files) -> Path:
    result = files.find(part.mesh)
    if result.path is None or result.how != "exact":
        there = result.path and result.path.relative_to(files.folder)
        raise RobotError(
            f"the mesh {part.mesh!r} of the link {part.name!r} "
            + {"outside": f"lies outside {files.folder}, where nothing is read"}.get(
                result.how, f"is not there{f', but {str(there)!r} is' if there else ''}"
            ),
            where=place.key("mesh"),
            fix="write where it is, from the folder of the table",
        )
    return result.path


def _mesh(path: Path) -> Mesh:
    return read_mesh(mesh_content(path), path.suffix, str(path))


def _joint(
    joint: JointTable, assembly: AssemblyTable, place: Place, places: dict[str, Array]
) -> DraftJoint:
    unit = UNITS[assembly.unit]
    lower, upper = _limits(joint, unit)
    position = unit * np.array(joint.origin) - places.get(joint.parent, np.zeros(3))
    turn = rotation(*(math.radians(angle) for angle in joint.turn_deg))
    axis = np.array(joint.axis or (1.0, 0.0, 0.0))
    return DraftJoint(
        name=joint.name,
        kind=joint.kind,
        parent=joint.parent,
        child=joint.child,
        pose=Pose(position=position, rotation=turn),
        axis=axis / np.linalg.norm(axis),
        lower=lower,
        upper=upper,
        effort=joint.effort,
        velocity=joint.velocity,
        damping=joint.damping,
        friction=joint.friction,
        line=_line(place, "name"),
    )


def _limits(joint: JointTable, unit: float) -> tuple[float | None, float | None]:
    if joint.limits_deg:
        return math.radians(joint.limits_deg[0]), math.radians(joint.limits_deg[1])
    if joint.limits:
        return unit * joint.limits[0], unit * joint.limits[1]
    return None, None


def _line(place: Place, key: str) -> int:
    return int(place.key(key).rpartition(":")[2])
