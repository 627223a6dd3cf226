"""Writing a robot as a clean description of its own, in MJCF or URDF."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

from morph.body.ground import flatten
from morph.body.postures import card_postures
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.told import posed
from morph.body.urdf_shapes import file_name
from morph.body.urdf_text import urdf_text
from morph.errors import OutputError
from morph.files import write_whole
from morph.regular_file import read_regular

FORMATS = {"mjcf": ("robot.xml", "assets"), "urdf": ("robot.urdf", "meshes")}
"""The description's name in each format, and its folder of meshes: two formats share a folder."""

FINDINGS = "findings.json"
"""What was found and repaired on the way; it marks a folder as one of ours."""

GROUND = "height fields: ground is no part of a robot, and Pinocchio reads none"
"""What is left out of an MJCF."""

SCHEMA = "morph.findings/1"
"""Name and version of its content."""

MOST_BYTES = 16 * 2**20
"""Largest file that is read to see whether it is ours: four times the longest description."""


@dataclass(frozen=True, kw_only=True)
class Conversion:
    """What was written."""

    files: tuple[Path, ...]
    """The description first, then what it names, then what was found."""
    left_out: tuple[str, ...]
    """What the format cannot hold."""


def convert(robot: Robot, to: str, folder: Path) -> Conversion:
    """Write a robot's description, its meshes and its findings into a folder.

    Everything is made beside the folder first and then moved in, the description
    last: stopped at any moment, no description is there whose meshes are not its own.

    Args:
        robot: The robot.
        to: `mjcf` or `urdf`.
        folder: New, empty, or written by an earlier conversion; what that wrote is
            replaced, files of other names stay.

    Returns:
        What was written. MuJoCo and Pinocchio load both formats with the mass that
        the robot has, yourdfpy the URDF; numbers are written with 17 digits.

    Raises:
        OutputError: The format is unknown; the folder is a file, holds something
            else or what the robot was read from, or cannot be written to.
    """
    if to not in FORMATS:
        raise OutputError(f"no format is called {to!r}", where=str(folder), fix="use mjcf or urdf")
    check_folder(folder, robot.source)
    name, inner = FORMATS[to]
    text, assets, left_out = _mjcf(robot, inner) if to == "mjcf" else urdf_text(robot, inner)
    contents: dict[str, str | bytes] = {f"{inner}/{each}": assets[each] for each in sorted(assets)}
    contents[FINDINGS] = _found(robot)
    contents[name] = text
    try:
        _write(contents, folder)
    except OSError as error:
        raise _unwritable(folder, error) from error
    files = (name, *(each for each in contents if each != name))
    return Conversion(files=tuple(folder / file for file in files), left_out=tuple(left_out))


def check_folder(folder: Path, source: Path | None = None) -> None:
    """Refuse a place that no description may be written to, before the work is done.

    Raises:
        OutputError: It is a file, a folder that holds something else or whose folder of
            meshes is a link or a file, or the folder of the description that was read.
    """
    try:
        if not folder.is_dir():
            if folder.exists() or folder.is_symlink():
                raise OutputError(
                    "this is a file, and a description is a folder",
                    where=str(folder),
                    fix="name a new or an empty folder",
                )
            return
        if any(folder.iterdir()) and not _ours(folder / FINDINGS):
            raise OutputError(
                "the folder is not empty and holds no earlier conversion",
                where=str(folder),
                fix=f"name a new or an empty folder, or one that holds a {FINDINGS} of morph",
            )
        for _, inner in FORMATS.values():
            # Through a link, meshes would be written outside the folder.
            if (folder / inner).is_symlink() or (folder / inner).is_file():
                raise OutputError(
                    "the folder for meshes is a link or a file",
                    where=str(folder / inner),
                    fix="take it away, or name a new or an empty folder",
                )
        if source is not None and folder.resolve() in source.resolve().parents:
            raise OutputError(
                "it would be written over what it is read from",
                where=str(folder),
                fix="name another folder",
            )
    except OSError as error:
        raise _unwritable(folder, error) from error


def _unwritable(folder: Path, error: OSError) -> OutputError:
    return OutputError(
        f"cannot write: {error.strerror or error}",
        where=str(folder),
        fix="choose a folder that can be written to and has room",
    )


def _ours(path: Path) -> bool:
    try:
        return bool(json.loads(read_regular(path, MOST_BYTES))["schema"] == SCHEMA)
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return False


def _found(robot: Robot) -> str:
    content = {
        "schema": SCHEMA,
        "name": robot.name,
        "source_sha256": robot.sha256,
        "findings": [finding.as_json() for finding in robot.findings],
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def _write(contents: dict[str, str | bytes], folder: Path) -> None:
    """Put files into a folder in their order; the last is taken away first and comes last."""
    folder.absolute().parent.mkdir(parents=True, exist_ok=True)
    made = Path(tempfile.mkdtemp(dir=folder.absolute().parent, prefix=f".{folder.name}."))
    try:
        made.chmod(0o755)
        for file, content in contents.items():
            write_whole(made / file, content)
        if not folder.exists():
            os.rename(made, folder)
            return
        (folder / list(contents)[-1]).unlink(missing_ok=True)
        for file in contents:
            (folder / file).parent.mkdir(exist_ok=True)
            os.replace(made / file, folder / file)
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _add_keyframes(tree: ElementTree.Element, robot: Robot) -> None:
    """Add the postures of a robot's card to its MJCF, as what is written has no such card."""
    postures = card_postures(robot)
    if not postures:
        return
    model = spec_of(robot).compile()
    keys = tree.find("keyframe")
    keys = ElementTree.SubElement(tree, "keyframe") if keys is None else keys
    for name, posture in postures.items():
        for other in [key for key in keys if key.get("name") == name]:
            keys.remove(other)
        pose = " ".join(map(repr, posed(robot, model, posture).tolist()))
        ElementTree.SubElement(keys, "key", name=name, qpos=pose)


def _mjcf(robot: Robot, inner: str) -> tuple[str, dict[str, bytes], tuple[str, ...]]:
    """Return a robot as MJCF, the files that it names, and what was left out."""
    tree = ElementTree.fromstring(robot.mjcf)
    left_out = (GROUND,) * flatten(tree)
    assets = {}
    for element in tree.iter():
        for key, file in list(element.attrib.items()):
            if key.startswith("file") and file in robot.assets:
                path = Path(file)
                safe = file_name(path.stem, path.suffix)
                assets[safe] = robot.assets[file]
                element.set(key, f"{inner}/{safe}")
    _add_keyframes(tree, robot)
    ElementTree.indent(tree)
    return ElementTree.tostring(tree, encoding="unicode") + "\n", assets, left_out
