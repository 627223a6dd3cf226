"""From a file, whatever it holds, to a Robot or a refusal with all that was found."""

from __future__ import annotations

from pathlib import Path

from morph.body.card import Card
from morph.body.paths import Files
from morph.body.refusal import about_file, refusal
from morph.body.robot import Robot
from morph.body.source import source_tree
from morph.errors import DescriptionRefused, RobotError

ENDINGS = (".urdf", ".xacro", ".xml", ".mjcf", ".toml")
"""Endings of the files that describe a robot: `.toml` is a table of joints between meshes."""

BASES = ("fixed", "floating", "board")
"""How a body may stand in the world."""


def read_description(
    path: Path, card: Card | None = None, *, base: str | None = None, folder: Path | None = None
) -> Robot:
    """Return the robot that a file describes.

    Args:
        path: A URDF, xacro or MJCF file, or an assembly of meshes in TOML.
        card: What the shelf knows about it.
        base: `fixed`, `floating` or `board`; it comes before the card's.
        folder: The folder outside which nothing is read; by default the
            description's own (`morph.body.paths.own_folder`).

    Raises:
        DescriptionRefused: There is no robot in it; its findings say why.
    """
    requested, base = base, base or (card.base if card else None)
    if base is not None and base not in BASES:
        raise RobotError(
            f"a base cannot be {base!r}", where=str(path), fix=f"use {', '.join(BASES)}"
        )
    try:
        robot = _read(path, card, base, folder)
        _check_base(robot, path, requested)
        return robot
    except DescriptionRefused:
        raise
    except RobotError as error:
        # A refusal without findings is one finding: about the file.
        raise refusal([about_file(error, path)]) from error
    except RecursionError as error:
        nested = RobotError("nests too deeply", where=str(path), fix="describe one robot")
        raise refusal([about_file(nested, path)]) from error


def _check_base(robot: Robot, path: Path, requested: str | None) -> None:
    """Refuse a base that the description does not leave open: nothing is overruled in silence."""
    first = robot.joints[0] if robot.joints else None
    stands = "fixed"
    if any(joint.kind == "free" for joint in robot.joints):
        stands = "floating"
    elif first is not None and first.kind == "slide" and first.name.startswith("board"):
        stands = "board"
    if requested and requested != stands:
        raise RobotError(
            f"the description says itself how its base stands: {stands}, not {requested}",
            where=str(path),
            fix="leave the base out, or change what ties the description's first link to the world",
        )


def _read(path: Path, card: Card | None, base: str | None, folder: Path | None) -> Robot:
    _check_place(path, folder)
    if path.suffix.lower() not in ENDINGS:
        raise RobotError(
            f"files that end in {path.suffix or 'nothing'!r} cannot be read",
            where=str(path),
            fix=f"give a file that ends in {', '.join(ENDINGS)}",
        )
    files = Files(path, folder)
    if path.suffix.lower() == ".toml":
        from morph.body.cad import read_cad
        from morph.body.urdf_robot import robot_from_draft

        return robot_from_draft(read_cad(path), [], files, card, base)
    tree = source_tree(path, files)
    if tree.tag == "mujoco":
        from morph.body.mjcf import robot_from_mjcf

        return robot_from_mjcf(tree, path, files, card)
    from morph.body.urdf import draft_urdf
    from morph.body.urdf_robot import robot_from_draft

    draft, findings = draft_urdf(tree, path)
    return robot_from_draft(draft, findings, files, card, base)


def _check_place(path: Path, folder: Path | None) -> None:
    try:
        path.stat()
        why = "" if path.is_file() else "is no file"
    except (OSError, ValueError) as error:
        why = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    if why:
        raise RobotError(
            why,
            where=str(path),
            fix="give a file that exists, or a name that `morph list robots` shows",
        )
    if folder is not None and folder.resolve() not in path.resolve().parents:
        raise RobotError(
            f"lies outside {folder}, and nothing outside it may be read",
            where=str(path),
            fix="name a folder that holds the description and its meshes",
        )
