"""Writing a robot as a clean description of its own, in MJCF or URDF."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from morph.body.robot import Robot
from morph.body.urdf_text import urdf_text
from morph.errors import OutputError
from morph.files import write_whole

MESHES = "meshes"
"""The folder of mesh files beside the description."""


@dataclass(frozen=True, kw_only=True)
class Conversion:
    """What was written."""

    files: tuple[Path, ...]
    """The description first, then what it names, then what was found."""
    left_out: tuple[str, ...]
    """What the format cannot hold."""


def convert(robot: Robot, to: str, folder: Path) -> Conversion:
    """Write a robot's description, its meshes and its findings into a folder.

    Args:
        robot: The robot.
        to: `mjcf` or `urdf`.
        folder: Made if need be; files of other names in it stay.

    Returns:
        What was written. MuJoCo and Pinocchio load both formats with the mass that
        the robot has, yourdfpy the URDF; numbers are written with 17 digits.

    Raises:
        OutputError: The format is unknown, or the folder cannot be written to.
    """
    if to == "mjcf":
        text, assets, left_out = _mjcf(robot), dict(robot.assets), ()
        name = "robot.xml"
    elif to == "urdf":
        text, assets, left_out = urdf_text(robot, MESHES)
        name = "robot.urdf"
    else:
        raise OutputError(f"no format is called {to!r}", where=str(folder), fix="use mjcf or urdf")
    written = [write_whole(folder / MESHES / file, assets[file]) for file in sorted(assets)]
    # The description comes last, so that it never names a file that is not there.
    written.append(write_whole(folder / name, text))
    findings = [finding.as_json() for finding in robot.findings]
    found = {"schema": "morph.findings/1", "name": robot.name, "findings": findings}
    found["source_sha256"] = robot.sha256
    written.append(write_whole(folder / "findings.json", json.dumps(found, indent=2) + "\n"))
    return Conversion(files=(written[-2], *written[:-2], written[-1]), left_out=left_out)


def _mjcf(robot: Robot) -> str:
    tree = ElementTree.fromstring(robot.mjcf)
    for element in tree.iter():
        for key in list(element.attrib):
            if key.startswith("file") and element.get(key) in robot.assets:
                element.set(key, f"{MESHES}/{element.get(key)}")
    ElementTree.indent(tree)
    return ElementTree.tostring(tree, encoding="unicode") + "\n"
