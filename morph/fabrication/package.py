"""Writing a package: plates, parts, the robot as it will be, and what is known of both."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

import morph
from morph.body.card import SCHEMA as CARD
from morph.body.card import Card, Checks, Citation
from morph.body.card_text import card_text
from morph.body.convert import FORMATS, convert
from morph.body.load import load
from morph.body.robot import FREEDOMS, Robot
from morph.errors import MakeError
from morph.fabrication.content import Package
from morph.fabrication.pack import packed
from morph.fabrication.packed import FILE
from morph.fabrication.printed import printed_robot
from morph.files import write_whole
from morph.print.bom import bill
from morph.print.errors import PrintError
from morph.print.job import Job
from morph.print.mesh import Mesh
from morph.print.part import Part
from morph.print.stl import stl
from morph.print.threemf import write_3mf

ROBOT, DESIGNED, POLICY = "robot", "designed", "policy"
"""Folders of the robot as it will be, as it was designed, and of its policy."""


def write_robots(folder: Path, robot: Robot, package: Package) -> Robot:
    """Write the robot as designed and as it will be, and return the latter as it is read back.

    Args:
        folder: The package's.
        robot: The body as it was designed.
        package: What its links weigh.

    Raises:
        MorphError: A robot cannot be written, or is not the same when it is read back.
    """
    _write_robot(folder / DESIGNED, robot, f"{robot.name} as designed", ())
    return write_printed(folder / ROBOT, robot, package)


def write_printed(folder: Path, robot: Robot, package: Package) -> Robot:
    """Write the robot with the masses that its parts have, and return it as it is read back.

    Raises:
        MorphError: It cannot be written, or is not the same when it is read back.
    """
    made = printed_robot(robot, package.links)
    sources = sorted({each.source for each in package.links})
    origin = Citation(
        what="masses, centres of mass and inertias of the links",
        from_=f"parts printed by morph {morph.__version__}: {', '.join(sources)}; see package.json",
    )
    return _write_robot(folder, made, f"{package.title}, as printed", (origin,))


def write_parts(folder: Path, job: Job, metadata: Mapping[str, str]) -> dict[str, str]:
    """Write every part and plate, and return their files in the package by their names.

    Parts lie as they are printed; plates are 3MF, with the metadata given. What was refused
    lies apart, so that nobody prints it by mistake.

    Raises:
        MakeError: A plate cannot be written.
        OutputError: The folder cannot be written to.
    """
    files = {}
    rooms = (("parts", job.parts), ("refused", job.refused), ("gauges", job.gauges))
    for room, parts in rooms:
        for part in parts:
            if part.mesh is not None:
                folded = "bought" if part.kind == "bought" else room
                files[part.name] = f"{folded}/{part.name}.stl"
                write_whole(folder / files[part.name], stl(_lying(part, part.mesh, job)))
    every = (*job.parts, *job.gauges)
    for plate in job.plates:
        files[plate.name] = f"plates/{plate.name}.3mf"
        path = folder / files[plate.name]
        path.parent.mkdir(exist_ok=True)
        try:
            write_3mf(path, plate, every, metadata=metadata)
        except PrintError as error:
            raise MakeError(error.what, where=error.where, fix=error.fix) from error
    write_whole(folder / "bom.csv", bill(job))
    return files


def write_content(folder: Path, package: Package, files: Mapping[str, str]) -> None:
    """Write `package.json`, which makes a folder a package; it comes last.

    Raises:
        OutputError: The folder cannot be written to.
    """
    text = json.dumps(asdict(packed(package, files)), indent=1, allow_nan=False)
    write_whole(folder / FILE, text + "\n")


def _lying(part: Part, mesh: Mesh, job: Job) -> Mesh:
    lies = job.orientations.get(part.name)
    if lies is None:
        return mesh
    pose = np.eye(4)
    pose[:3, :3] = lies.turn
    return mesh.moved(pose)


def _write_robot(folder: Path, robot: Robot, title: str, origins: tuple[Citation, ...]) -> Robot:
    name = folder.name
    for form in FORMATS:
        convert(replace(robot, name=name), form, folder)
    write_whole(folder / "card.toml", card_text(_card(robot, name, title, origins)))
    result = load(folder)
    same_joints = [joint.name for joint in result.joints] == [joint.name for joint in robot.joints]
    # The card's own check holds masses to 1e-9; this one holds names.
    if not same_joints:
        raise MakeError(
            f"what was written of {robot.name} has other joints than it",
            where=str(folder),
            fix="tell the authors which body it was",
        )
    return result


def _card(robot: Robot, name: str, title: str, origins: tuple[Citation, ...]) -> Card:
    """Return the card of a robot in a package: what still holds of the original's."""
    before = robot.card
    floats = any(joint.kind == "free" for joint in robot.joints)
    stated = Citation(
        what="everything else",
        from_=f"the robot {robot.name}, by morph {morph.__version__}",
    )
    checks = Checks(mass_kg=robot.mass, dof=sum(FREEDOMS[each.kind] for each in robot.joints))
    base = before.base if before is not None else "floating" if floats else "fixed"
    return Card(
        schema=CARD,
        name=name,
        title=title,
        description="robot.xml",
        base=base,
        source=(*origins, stated, *(before.source if before is not None else ())),
        licence=before.licence if before is not None else "NOASSERTION",
        tasks=before.tasks if before is not None else (),
        checks=checks,
        water=before.water if before is not None else None,
        motor=before.motor if before is not None else (),
        parameter=before.parameter if before is not None else (),
        print=before.print if before is not None else None,
    )
