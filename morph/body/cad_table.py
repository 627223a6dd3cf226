"""The tables of `assembly.toml`, and what their values must be."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

from morph.body.draft import MOVING
from morph.body.table import Place, read_table
from morph.errors import RobotError
from morph.toml_file import load_toml

SCHEMA = "morph.assembly/1"
"""The only schema of assemblies so far."""

UNITS = {"mm": 0.001, "m": 1.0}
"""Metres in each unit of length."""

FRAMES = ("link", "assembly")
"""In what frame meshes and joints are given."""

TURNING, ALONG_AXIS = "revolute", ("revolute", "continuous", "prismatic")

MOST_LINKS = 1000
"""Most links, and most joints; as many as of a URDF."""

LARGEST_FILE = 2**20
"""Longest table, bytes: ten thousand links."""

FARTHEST = 1e6
"""Greatest number in a table, in any unit."""

DENSEST = 25_000.0
"""Greatest density, kg/m3; osmium has 22 590."""


@dataclass(frozen=True, kw_only=True)
class PartTable:
    """A link: one mesh and its mass; the key of these tables is `link`."""

    name: str
    """Its name."""
    mesh: str
    """The mesh's file, beside the table or below it."""
    unit: str | None = None
    """Unit of the mesh, `mm` or `m`; by default that of the assembly."""
    density_kg_m3: float | None = None
    """Density; by default that of the assembly."""
    mass_kg: float | None = None
    """Mass as weighed; it comes before any density."""


@dataclass(frozen=True, kw_only=True)
class JointTable:
    """A joint between two links; the key of these tables is `joint`."""

    name: str
    """Its name."""
    parent: str
    """The link that carries it."""
    child: str
    """The link that it moves."""
    kind: str
    """`fixed`, `revolute`, `continuous`, `prismatic`, `ball`, `planar` or `floating`."""
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Where it is, in the assembly's unit."""
    turn_deg: tuple[float, ...] = (0.0, 0.0, 0.0)
    """How the child's frame is turned: about x, then y, then z of the parent's, as in URDF."""
    axis: tuple[float, ...] = ()
    """Its axis, in the child's frame."""
    limits_deg: tuple[float, ...] = ()
    """revolute: least and greatest angle."""
    limits: tuple[float, ...] = ()
    """prismatic: least and greatest position, in the assembly's unit."""
    effort: float | None = None
    """Greatest effort, N m or N."""
    velocity: float | None = None
    """Greatest speed, rad/s or m/s."""
    damping: float = 0.0
    """N m s/rad or N s/m."""
    friction: float = 0.0
    """N m or N."""


@dataclass(frozen=True, kw_only=True)
class AssemblyTable:
    """A whole `assembly.toml`."""

    schema: str
    """`morph.assembly/1`."""
    name: str
    """What the body is called."""
    unit: str
    """Unit of origins, of limits along an axis and of meshes: `mm` or `m`."""
    link: tuple[PartTable, ...]
    """Its links."""
    joint: tuple[JointTable, ...] = ()
    """Its joints."""
    frame: str = "link"
    """`link`: each mesh is in its link's frame, each joint in its parent's; `assembly`: all are
    in the one frame in which the parts were drawn together."""
    density_kg_m3: float | None = None
    """Density of the links that give none."""


def read_assembly(path: Path) -> tuple[AssemblyTable, Place]:
    """Return the tables in a file, and the place to find the lines of their keys.

    Raises:
        RobotError: The file cannot be read, a key is unknown or missing, or a value
            is not one allowed; the line is named.
    """
    try:
        table, text = load_toml(path, LARGEST_FILE)
    except OSError as error:
        raise RobotError(
            f"cannot be read: {error.strerror or error}", where=str(path), fix="give the table"
        ) from error
    except ValueError as error:
        raise RobotError(
            f"is not TOML: {error}", where=str(path), fix="correct the line it names"
        ) from error
    place = Place(file=str(path), text=text)
    assembly = read_table(AssemblyTable, table, place)
    _check(assembly, place)
    return assembly, place


def _check(assembly: AssemblyTable, place: Place) -> None:
    _one_of(assembly.schema, (SCHEMA,), "schema", place)
    _one_of(assembly.unit, tuple(UNITS), "unit", place)
    _one_of(assembly.frame, FRAMES, "frame", place)
    if assembly.density_kg_m3 is not None:
        _within(assembly.density_kg_m3, DENSEST, "density_kg_m3", place)
    for kind, count in (("link", len(assembly.link)), ("joint", len(assembly.joint))):
        if count > MOST_LINKS:
            raise RobotError(
                f"has {count} {kind}s; a body has {MOST_LINKS} at most",
                where=replace(place, section=kind, index=MOST_LINKS).key("name"),
                fix="describe one body a file",
            )
    for at, link in enumerate(assembly.link):
        _check_link(link, assembly, replace(place, section="link", index=at))
    for at, joint in enumerate(assembly.joint):
        _check_joint(joint, assembly, replace(place, section="joint", index=at))
    for kind, parts in (("link", assembly.link), ("joint", assembly.joint)):
        names = [part.name for part in parts]
        for at, name in enumerate(names):
            if not name.strip():
                raise RobotError(
                    f"a {kind} has no name",
                    where=replace(place, section=kind, index=at).key("name"),
                    fix="give it a name of its own",
                )
        for name, count in Counter(names).items():
            if count > 1:
                last = len(names) - 1 - names[::-1].index(name)
                raise RobotError(
                    f"{count} {kind}s are called {name!r}",
                    where=replace(place, section=kind, index=last).key("name"),
                    fix=f"give each {kind} a name of its own",
                )


def _check_link(link: PartTable, assembly: AssemblyTable, place: Place) -> None:
    if link.unit is not None:
        _one_of(link.unit, tuple(UNITS), "unit", place)
    if link.mass_kg is not None:
        _within(link.mass_kg, FARTHEST, "mass_kg", place)
    if link.density_kg_m3 is not None:
        _within(link.density_kg_m3, DENSEST, "density_kg_m3", place)
    if link.mass_kg is link.density_kg_m3 is assembly.density_kg_m3 is None:
        raise RobotError(
            f"the link {link.name!r} has neither mass nor density",
            where=place.key("name"),
            fix="add mass_kg = ... or density_kg_m3 = ..., here or at the top of the file",
        )


def _check_joint(joint: JointTable, assembly: AssemblyTable, place: Place) -> None:
    _one_of(joint.kind, ("fixed", *MOVING), "kind", place)
    lengths = {"origin": 3, "turn_deg": 3, "axis": 3, "limits_deg": 2, "limits": 2}
    optional = {"axis", "limits_deg", "limits"}
    for key, length in lengths.items():
        values = getattr(joint, key)
        if key in optional and not values:
            continue
        if len(values) != length or not all(abs(value) <= FARTHEST for value in values):
            raise _bad(key, list(values), f"{length} numbers within {FARTHEST:g}", place)
    if joint.kind in ALONG_AXIS and not any(joint.axis):
        raise _bad("axis", list(joint.axis), "a direction, as joints of this kind need one", place)
    wanted = {"revolute": "limits_deg", "prismatic": "limits"}.get(joint.kind)
    for key in ("limits_deg", "limits"):
        if getattr(joint, key) and key != wanted:
            raise _bad(key, list(getattr(joint, key)), f"for a joint that is {joint.kind}", place)
    if joint.kind == TURNING and not joint.limits_deg:
        raise _bad("limits_deg", [], "given, and a joint that turns freely is continuous", place)
    if assembly.frame == "assembly" and any(joint.turn_deg):
        raise _bad("turn_deg", list(joint.turn_deg), "0, as all frames are the assembly's", place)
    for key in ("effort", "velocity"):
        if getattr(joint, key) is not None:
            _within(getattr(joint, key), math.inf, key, place)
    for key in ("damping", "friction"):
        if not 0.0 <= getattr(joint, key) <= FARTHEST:
            raise _bad(key, getattr(joint, key), "from 0", place)


def _one_of(value: str, allowed: tuple[str, ...], key: str, place: Place) -> None:
    if value not in allowed:
        raise _bad(key, value, " or ".join(repr(name) for name in allowed), place)


def _within(value: float, most: float, key: str, place: Place) -> None:
    if not 0.0 < value <= most:
        raise _bad(key, value, f"above 0 and at most {most:g}", place)


def _bad(key: str, value: object, wanted: str, place: Place) -> RobotError:
    return RobotError(
        f"{key} is {value!r}, not {wanted}",
        where=place.key(key),
        fix=f"correct {key}; docs/bodies.md lists what it may be",
    )
